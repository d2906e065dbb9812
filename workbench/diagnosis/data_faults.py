"""Data faults before causes: wild points, swapped and frozen targets, an instrument or tool that moved.

Each is found on a robust geometry fit, named with its pose, and either mended or left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from ..campaign import Campaign
from ..campaign.problem import Problem
from ..effects import catalogue
from ..identification.fit import Fit, fit
from ..identification.model import Model, State
from ..identification.noise import Covariance
from ..robot.kinematics import Array
from .families import families
from .result import FaultFound
from .screen import effective_dof, quadratic, reduce_columns

FAR = 6.0  # robust standard deviations per axis from which a point is an outlier


@dataclass(frozen=True)
class Cleaned:
    """The problem without its data faults, a robust geometry fit of it, and what was found."""

    problem: Problem
    fit: Fit
    faults: tuple[FaultFound, ...]


def clean(
    problem: Problem, start: State, noise: Covariance, known_effects: tuple = (), judged: bool = True
) -> Cleaned:
    """Finds data faults and mends them or leaves the points out."""
    faults: list[FaultFound] = []
    problem, frozen = _frozen(problem)
    faults += frozen
    for _ in range(4):
        result = robust_fit(problem, start, noise, known_effects)
        problem, found = _mend(problem, result, noise if judged else None)
        faults += found
        if not found:
            break
        start = result.state
    return Cleaned(problem, result, tuple(faults))


def robust_fit(problem: Problem, start: State, noise: Covariance, known_effects: tuple = ()) -> Fit:
    """Geometry fit in which a pose counts less the farther it is off (weights of Student's t, 4 dof)."""
    weight = noise.weight.copy()
    model = Model(problem, (), known_effects)
    for _ in range(6):
        result = fit(model, start, replace(noise, weight=weight), max_iterations=12)
        start = result.state
        size = _pose_size(result, weight)
        scale = float(np.median(size[weight > 0])) + 1e-12
        new = noise.weight * np.sqrt(5 / (4 + (size / scale) ** 2))
        if float(np.abs(new - weight).max()) < 0.02:
            break
        weight = new
    return result


def _pose_size(result: Fit, weight: Array) -> Array:
    """(N,) rms of the whitened residual of each pose, weights taken out."""
    r = result.point_residual
    rows = np.maximum((np.abs(result.whitener[:, : r.shape[1]]).sum(axis=2) > 0).sum(axis=1), 1)
    size = np.sqrt((r**2).sum(axis=1) / rows)
    return np.asarray(size / np.where(weight > 0, weight, 1.0))


def _mend(problem: Problem, result: Fit, noise: Covariance | None) -> tuple[Problem, list[FaultFound]]:
    """One round: outlier points, first tried as swapped targets."""
    length = np.linalg.norm(result.residual, axis=2)
    limit = _limit(length, noise)
    wild = np.where(np.isfinite(length), length > limit, False)
    if not wild.any():
        return problem, []
    c = problem.campaign
    points = c.points.copy()
    faults = []
    # the worst first: a wild point pulls its neighbours, so only what is near the worst goes now
    worst = np.nanmax(np.where(wild, length, 0.0) / limit, axis=1)
    top = worst.max()
    for n in np.flatnonzero(worst > max(1.0, 0.25 * top)):
        order = _swap(result, c, int(n), limit)
        if order is not None:
            points[n] = points[n][list(order)]
            names = [c.targets[i].name for i in range(len(order)) if order[i] != i]
            faults.append(
                FaultFound(
                    "swapped_target",
                    c.pose_ids[n],
                    " and ".join(names),
                    "targets exchanged",
                    "exchanged back",
                )
            )
            continue
        for i in np.flatnonzero(wild[n]):
            what = f"{length[n, i] * 1e3:.2f} mm off, others typically {np.nanmedian(length) * 1e3:.2f} mm"
            points[n, i] = np.nan
            target = c.targets[i].name if len(c.targets) > 1 else None
            faults.append(FaultFound("outlier", c.pose_ids[n], target, what, "left out"))
    return replace(problem, campaign=replace(c, points=points)), faults


def _limit(length: Array, noise: Covariance | None) -> Array:
    """(1, T) distance from which a point is wild: robust scale per target, never below the noise's."""
    middle = np.array([np.nanmedian(column) if np.isfinite(column).any() else np.inf for column in length.T])
    sigma = middle / 1.538  # median of a 3-D normal's length
    if noise is not None:
        sigma = np.maximum(sigma, np.nanmedian(noise.sigma, axis=0))
    return np.asarray(FAR * np.sqrt(3) * sigma)[None]


def _swap(result: Fit, c: Campaign, n: int, limit: Array) -> Sequence[int] | None:
    """The order of the targets that makes pose n fit; None when no exchange does."""
    n_targets = c.points.shape[1]
    if n_targets < 2 or n_targets > 5 or not np.isfinite(c.points[n]).all():
        return None
    predicted = result.line.prediction.points[n]
    for order in permutations(range(n_targets)):
        if list(order) == list(range(n_targets)):
            continue
        if (np.linalg.norm(c.points[n][list(order)] - predicted, axis=1) < limit[0]).all():
            return order
    return None


def _frozen(problem: Problem) -> tuple[Problem, list[FaultFound]]:
    """Points that repeat the pose before to the last digit although the joints have moved."""
    c = problem.campaign
    points = c.points.copy()
    faults = []
    for i, target in enumerate(c.targets):
        if problem.on[i] == 0:
            continue
        expected = problem.rigid.points(np.nan_to_num(problem.stated_targets), problem.on)[:, i]
        still = np.all(np.abs(np.diff(c.points[:, i], axis=0)) < 1e-9, axis=1)
        moved = np.linalg.norm(np.diff(expected, axis=0), axis=1) > 1e-3
        for n in np.flatnonzero(still & moved) + 1:
            points[n, i] = np.nan
            faults.append(
                FaultFound(
                    "frozen_target", c.pose_ids[n], target.name, "same numbers as the pose before", "left out"
                )
            )
    if not faults:
        return problem, []
    return replace(problem, campaign=replace(c, points=points)), faults


@dataclass(frozen=True)
class Step:
    """A step in time: kind of data fault, first pose after it, size [m], statistic."""

    kind: str
    first: int
    size: float
    statistic: float


def step_in_time(result: Fit) -> Step | None:
    """A moved instrument, or a tool that was mounted anew; None when nothing steps.

    Every place in the measured order is tried; a step must beat a steady drift clearly.
    """
    c = result.model.problem.campaign
    if len(c.setup_names) > 1 or len(c.q) < 20:
        return None
    flange = result.line.direct[:, :, -6:]
    steps = [
        _step(result, kind, np.matmul(result.whitener, columns))
        for kind, columns in (("moved_instrument", result.line.frame), ("changed_setup", flange))
    ]
    return max((step for step in steps if step), key=lambda step: step.statistic, default=None)


def _step(result: Fit, kind: str, base: Array) -> Step | None:
    """The best step of the motions base: (N, D, 6), whitened; None when none is clear."""
    n_poses = len(base)
    ramp = np.linspace(-1, 1, n_poses)
    S, u, own = reduce_columns(result, base * ramp[:, None, None])
    drift, _ = quadratic(S, u, np.maximum(own, 1e-300))
    before = _prefix(result, base)
    gains = []
    for k in range(5, n_poses - 4):
        S, u, own = before(k)
        gains.append(quadratic(S, u, np.maximum(own, 1e-300))[0])
    gain, first = max(gains), 5 + int(np.argmax(gains))
    # against what the residual scatters anyway: an unknown effect is no step
    scatter = max(1.0, result.chi2 / effective_dof(result))
    if gain < 60 * scatter or gain < drift + 40 * scatter:
        return None
    step = base * (np.arange(n_poses) < first)[:, None, None]
    if _beside_joints(result, step) < 60 * scatter:
        return None
    S, u, own = before(first)
    size = float(np.linalg.norm((np.linalg.pinv(S, hermitian=True) @ u)[:3]))
    return Step(kind, first, size, gain)


def _beside_joints(result: Fit, step: Array) -> float:
    """Statistic of a step when smooth functions of every joint, stiffness and payload are taken out first.

    Poses measured joint by joint, or load by load, would else let their errors look like a step.
    """
    smooth = np.concatenate(
        [f.columns for f in families(result) if f.joint is not None] + _load_columns(result), axis=2
    )
    if result.J.shape[2] + smooth.shape[2] > 0.6 * result.point_rows:
        return 0.0
    S, u, own = reduce_columns(result, np.concatenate([smooth, step], axis=2))
    n = smooth.shape[2]
    length = np.sqrt(np.maximum(own, 1e-12 * own.max()))  # what moves nothing stays nothing
    S, u = S / np.outer(length, length), u / length
    solved = np.linalg.solve(S[:n, :n] + 1e-8 * np.eye(n), np.column_stack([S[:n, n:], u[:n]]))
    left = S[n:, n:] - S[n:, :n] @ solved[:, :-1]
    return quadratic(left, u[n:] - S[n:, :n] @ solved[:, -1], np.ones(step.shape[2]))[0]


def _load_columns(result: Fit) -> list[Array]:
    """Whitened columns of what a change of load does."""
    problem, model = result.model.problem, result.model
    effects = [e for cause in ("payload", "joint_compliance") for e in catalogue()[cause].sites(problem)]
    return [
        np.matmul(result.whitener, model.effect_jacobian(result.line, e, np.zeros(len(e.params))))
        for e in effects
    ]


def _prefix(result: Fit, base: Array) -> Callable[[int], tuple[Array, Array, Array]]:
    """S, u, own of "a step before pose k" for all k, by running sums."""
    from scipy.linalg import solve_triangular

    gram = np.cumsum(np.einsum("ndi,ndj->nij", base, base), axis=0)
    score = np.cumsum(np.einsum("ndi,nd->ni", base, result.r), axis=0)
    back = np.cumsum(np.einsum("ndp,ndi->npi", result.J * result.columns.prior, base), axis=0)

    def at(k: int) -> tuple[Array, Array, Array]:
        Z = solve_triangular(result.upper, back[k - 1], trans="T")
        return gram[k - 1] - Z.T @ Z, score[k - 1], np.diag(gram[k - 1]).copy()

    return at


def split_setup(problem: Problem, first: int) -> Problem:
    """The problem with the poses from `first` on in a set-up of their own."""
    c = problem.campaign
    setup: NDArray[np.int64] = c.setup.copy()
    setup[first:] = len(c.setup_names)
    names = (*c.setup_names, f"{c.setup_names[0] or 'setup'} after pose {c.pose_ids[first - 1]}")
    return replace(problem, campaign=replace(c, setup=setup, setup_names=names))
