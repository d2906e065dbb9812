"""Which of many possible records to measure: the exchange of Fedorov (1972) with exact gains.

With V = M⁻¹ the covariance of the parameters, a further record with whitened rows A (D, P) changes the
criterion tr(A0 V A0ᵀ) of Klimchik et al. (2017), eqs. (17) and (18), by Woodbury's identity exactly by

    g = tr(S⁻¹ A V A0ᵀ A0 V Aᵀ),   S = I + A V Aᵀ

which is worked out for all candidates at once. Records are exchanged one by one until no exchange helps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...campaign.cell import DrivingData
from ...files.faults import Fault, InputError
from ...robot.kinematics import Array
from ..driving.reach import Draw

Records = NDArray[np.int64]
Cost = Callable[[Records], Array]

RIDGE = 1e-10  # information that stands in for none while a plan cannot identify everything yet
UNSEEN = 1e-11  # information, of what all candidates together give, below which a direction is unseen
BETTER = 1e-7  # relative gain below which an exchange is rounding, no improvement
PASSES = 50


@dataclass(frozen=True)
class Search:
    """How long to look: candidate records on offer (about), random starts of the exchange, and the seed; and
    of which poses: draw (None: any within the limits), driving: what is possible beside."""

    pool: int
    starts: int
    seed: int
    draw: Draw | None = None
    driving: DrivingData = field(default_factory=DrivingData)


def exchange(
    candidates: Array,
    A0: Array,
    count: int,
    *,
    prior: Array | None = None,
    starts: int = 5,
    seed: int = 0,
) -> tuple[Records, float]:
    """Fedorov exchange. candidates: (C, D, P) whitened rows of each possible record; a record is chosen
    once at most (what may be measured twice stands twice among the candidates). A0: (D0, P) rows whose
    mean squared error counts; prior: (P, P) information that is there already.

    Returns the chosen records (count,), sorted, and rho0 = sqrt(tr(A0 M⁻¹ A0ᵀ)), M = prior + Σ AᵀA; no
    single exchange lowers it. The best of some random starts. Raises InputError where there are too few
    candidates, and where no such plan identifies what A0 asks for.
    """
    C, _, P = candidates.shape
    check_count(count, C)
    scale = unit_scale(candidates, prior)
    rows, asked = candidates * scale, A0 * scale
    held: Array = RIDGE * np.eye(P) + (0.0 if prior is None else prior * np.outer(scale, scale))
    Q = _root(asked.T @ asked)

    def cost(rest: Records) -> Array:
        V = np.asarray(np.linalg.inv(held + information(rows[rest])), dtype=np.float64)
        return float(np.sum((Q.T @ V) * Q.T)) - gains(rows, V, Q)

    best = search(cost, C, count, starts, seed)
    rho0 = criterion(candidates[best], A0, prior)
    if not np.isfinite(rho0):
        what = f"{count} records of these candidates cannot identify all that the prediction needs"
        raise InputError(Fault("plan", what, "take more records, or offer other poses, loads and targets"))
    return best, rho0


def criterion(rows: Array, A0: Array, prior: Array | None = None) -> float:
    """sqrt(tr(A0 M⁻¹ A0ᵀ)) of a plan, M = prior + Σ AᵀA, rows: (N, D, P) or (N·D, P); infinite where A0
    asks for a direction of which the plan and the prior say nothing."""
    flat = rows.reshape(-1, rows.shape[-1])
    scale = unit_scale(flat[None], prior)
    M = (flat * scale).T @ (flat * scale)
    if prior is not None:
        M = M + prior * np.outer(scale, scale)
    values, vectors = np.linalg.eigh(M)
    asked = (A0 * scale) @ vectors
    seen = values > UNSEEN * max(float(values[-1]), 1e-300)
    if np.abs(asked[:, ~seen]).max(initial=0.0) > 1e-6 * max(float(np.abs(asked).max(initial=0.0)), 1e-300):
        return float("inf")
    return float(np.sqrt(np.sum(asked[:, seen] ** 2 / values[seen])))


def search(cost: Cost, C: int, count: int, starts: int, seed: int) -> Records:
    """The records (count,) of least cost that exchanges reach from some random starts, sorted.

    cost(rest) says for each of C candidates what the plan `rest` (count − 1,) costs with it added.
    """
    found: list[tuple[float, Records]] = []
    for start in range(starts):
        rng = np.random.default_rng([seed, start])
        found.append(improve(cost, rng.choice(C, count, replace=False)))
    return min(found, key=lambda pair: pair[0])[1]


def improve(cost: Cost, plan: Records) -> tuple[float, Records]:
    """Every record in turn gives way to the best candidate in its place, until none does: cost and plan."""
    plan, value, kept = plan.copy(), np.inf, 0
    for step in range(PASSES * len(plan)):
        k = step % len(plan)
        rest = np.delete(plan, k)
        costs = cost(rest)
        now = float(costs[plan[k]])
        costs[rest] = np.inf
        best = int(np.argmin(costs))
        if now - float(costs[best]) > BETTER * abs(now):
            plan[k], value, kept = best, float(costs[best]), 0
        else:
            value, kept = now, kept + 1
        if kept == len(plan):
            break
    return value, np.sort(plan)


def gains(rows: Array, V: Array, Q: Array) -> Array:
    """(C,) what each candidate takes off tr(Qᵀ V Q), for Q: (P, k)."""
    AV = rows @ V
    S = np.matmul(AV, rows.swapaxes(1, 2)) + np.eye(rows.shape[1])
    AVQ = AV @ Q
    return np.asarray(np.sum(np.linalg.inv(S) * np.matmul(AVQ, AVQ.swapaxes(1, 2)), axis=(1, 2)))


def information(rows: Array) -> Array:
    """(P, P) Fisher information Σ AᵀA of whitened rows (..., P)."""
    flat = rows.reshape(-1, rows.shape[-1])
    return np.asarray(flat.T @ flat)


def check_count(count: int, C: int) -> None:
    """Raises InputError where so many records cannot be chosen."""
    if not 1 <= count <= C:
        raise InputError(Fault("plan", f"{count} records of {C} possible ones", f"ask for 1 to {C}"))


def unit_scale(rows: Array, prior: Array | None) -> Array:
    """(P,) units in which all rows and the prior together have information one of each parameter."""
    total = np.einsum("cdp,cdp->p", rows, rows)
    if prior is not None:
        total = total + np.diag(prior)
    return 1 / np.sqrt(np.where(total > 0, total, 1.0))


def _root(M: Array) -> Array:
    """(P, k) with Q Qᵀ = M, k its rank."""
    values, vectors = np.linalg.eigh(M)
    kept = values > 1e-12 * max(float(values[-1]), 1e-300)
    return np.asarray(vectors[:, kept] * np.sqrt(values[kept]))
