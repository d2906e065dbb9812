"""Where something steps in time: every place in the order of measurement tried at once, by running sums."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from ...campaign.in_motion import in_motion
from ...campaign.path_sides import sides_along
from ...campaign.problem import Problem
from ...effects.base import Effect
from ...effects.unnamed import steps
from ...identification.fit import Fit
from ...robot.kinematics import Array
from ..priors import PRIORS
from .screen import SURVIVES, still_to_go

DIFFERENT = 5  # poses before and after a step
STRETCHES = 12  # of a path: each is one look
ORDERS, CLEARLY = 11, 3.0  # drawn at random, and times what chance makes a step of in the middle one of them
MOST = 3  # steps of one kind at once


@dataclass(frozen=True, eq=False)
class Taken:
    """What a fit, and steps that were found beside it, take of whitened columns. axes: (N, D, P) along which
    its numbers are known to 1, to_go: (P,) what these would still take of the residual r (N, D)."""

    axes: Array
    to_go: Array
    r: Array

    @classmethod
    def by(cls, fit: Fit) -> Taken:
        return cls(fit.own_axes, still_to_go(fit), fit.r)

    def and_of(self, columns: Array) -> Taken:
        """With columns (N, D, m) beside it."""
        flat = columns.reshape(-1, columns.shape[2])
        Z, gram = self.axes.reshape(len(flat), -1).T @ flat, flat.T @ flat
        half = half_of(gram - Z.T @ Z, np.diag(gram))
        axes = (columns - self.axes @ Z) @ half
        to_go = half.T @ (flat.T @ self.r.ravel() - Z.T @ self.to_go)
        return Taken(np.concatenate([self.axes, axes], axis=2), np.concatenate([self.to_go, to_go]), self.r)


def likely_steps(result: Fit) -> Iterator[list[tuple[Effect, float]]]:
    """A step of each kind where it explains most, and how far the data tell this place from the others: the
    share of all places that are about as likely. Behind one that is no chance, as far as its prior asks, a
    further one of its kind that is none beside it. None among rows that were measured in motion."""
    problem = result.model.problem
    c, positions = problem.campaign, problem.positions
    if in_motion(c.poses.q, c.poses.time):
        return
    for step in steps(problem):
        each = step.stretches(problem)
        possible = [places(positions[own]) for own in each]
        where = [int(own[i]) for own, some in zip(each, possible, strict=True) for i in some]
        base = np.matmul(result.whitener, result.line.direct[:, :, step.columns(problem)])
        taken, found = Taken.by(result), list[tuple[Effect, float]]()
        while where and len(found) < MOST:
            parts = zip(each, possible, strict=True)
            gains = np.concatenate([gains_of(*prefix(taken, base, own))[some] for own, some in parts])
            best = int(gains.argmax())
            share = float(np.exp(0.5 * (gains - gains[best])).mean())
            explains = chdtrc(base.shape[2], gains[best]) < PRIORS.free * share
            there = replace(step, first=float(where[best]), pose=c.poses.ids[where[best]])
            if explains or not found:
                found.append((there, share))
            if not explains:
                break
            taken = taken.and_of(base * there.after(problem)[:, :, None])
        if found:
            yield found


def gains_of(S: Array, u: Array, own: Array) -> Array:
    """(K,) what each of K steps takes off χ², of S (K, m, m), u (K, m) and own (K, m) as `quadratic` has
    them."""
    half = half_of(S, own)
    return np.asarray(((half.swapaxes(1, 2) @ u[..., None]) ** 2).sum(axis=(1, 2)))


def half_of(S: Array, own: Array) -> Array:
    """(..., m, m) H with H Hᵀ = S⁺ of S (..., m, m), without what was swallowed of lengths² own (..., m)."""
    length = np.sqrt(np.maximum(own, 1e-300))
    values, axes = np.linalg.eigh(S / (length[..., :, None] * length[..., None, :]))
    size = np.where(values > SURVIVES, values, np.inf)
    return np.asarray(axes / np.sqrt(size)[..., None, :] / length[..., :, None])


def by_chance(
    result: Fit, base: Array, own: NDArray[np.int64], possible: Sequence[int], taken: Taken
) -> float:
    """The most that a step of the poses `own` takes off χ², at places `possible` among these, in the middle
    one of some orders of the positions, drawn at random:
    what a model lacks is alike in a pose's points and in its repeats, and looks more like a step than as many
    independent errors do. So it does along a path and while most joints are held: such runs stay whole."""
    problem, rng = result.model.problem, np.random.default_rng(0)
    together = _alike(problem)
    most = []
    for _ in range(ORDERS):
        order = own[np.argsort(rng.permutation(int(together.max()) + 1)[together[own]], kind="stable")]
        most.append(gains_of(*prefix(taken, base, order))[possible].max())
    return float(np.median(most))


def _alike(problem: Problem) -> NDArray[np.int64]:
    """(N,) number of what stays together where the order of measurement is drawn anew: of the repeats of a
    position, or, where it is longer, of the run of poses in which most joints are held. Along a path, and of
    few such runs, it is a stretch of the campaign."""
    q, positions = problem.q, problem.positions
    runs = problem.campaign.poses.runs
    stretches = np.arange(len(q)) * STRETCHES // len(q)
    if sides_along(q, problem.campaign.poses.setup, None) is not None:
        return stretches
    if runs.max() >= positions.max():
        return positions
    return runs if runs.max() >= STRETCHES else stretches


def places(positions: NDArray[np.int64]) -> list[int]:
    """Where a step may be: between poses enough of which differ to place frame and targets. Returns to a few
    places anew place neither."""

    def met(order: NDArray[np.int64]) -> NDArray[np.int64]:
        new = np.zeros(len(order), dtype=np.int64)
        new[np.unique(order, return_index=True)[1]] = 1
        return np.cumsum(new)

    before, after = met(positions), met(positions[::-1])[::-1]
    return [int(k) for k in range(1, len(positions)) if min(before[k - 1], after[k]) >= DIFFERENT]


def prefix(taken: Taken, base: Array, order: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """S (K, m, m), u (K, m), own (K, m) of a step of m motions base (N, D, m) before each pose of an order
    (K,), by running sums."""
    across = base[order].swapaxes(1, 2)
    beside = base[order], taken.r[order, :, None], taken.axes[order]
    gram, score, Z = (_before(across @ other) for other in beside)
    u = score[..., 0] - Z @ taken.to_go
    return gram - Z @ Z.swapaxes(1, 2), u, np.diagonal(gram, axis1=1, axis2=2)


def _before(each: Array) -> Array:
    """(K, ...) sums of what comes before each."""
    return np.concatenate([np.zeros_like(each[:1]), np.cumsum(each, axis=0)[:-1]])
