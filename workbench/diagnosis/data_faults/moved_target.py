"""One target of several that sits elsewhere on its body from a pose on, or for a while: a nest that was
bumped, a reflector that was seated badly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from ...campaign.problem import Problem
from ...identification.fit import Fit
from ...identification.noise import LEAST
from ...robot.kinematics import Array
from ..found import FaultFound
from .rounded_joints import shared_rounding

FEWEST = 5  # poses on either side of a step
CHANCE = 1e-4  # that any target of a sound campaign is said to have moved
TIMES = 100.0  # as likely as any creeping
BESIDE = 1e-4  # chance of a step beside something smooth, or of one of the other targets
PLACES = 300  # where a step is tried at most: in more poses, every so many
CLIPPED = 5.0  # robust standard deviations: a wild point counts no more
WAVES = 4  # cosines in the order of measurement: what a drift may look like
SETTLING = (0.04, 0.08, 0.16, 0.32)  # of a campaign: what comes to rest takes so long


@dataclass(frozen=True)
class Reseated:
    """A target that sits elsewhere by size [m], from pose first on; up to last, where it comes back.
    rest: (N,) poses that see it, those before and after or those there: the fewer."""

    target: int
    first: int
    last: int | None
    size: float
    rest: NDArray[np.bool_]

    def fault(self, problem: Problem) -> FaultFound:
        """As a data fault of the first pose that sees it elsewhere."""
        c = problem.campaign
        name, ids = c.targets[self.target].name, c.poses.ids
        until = "" if self.last is None else f" up to pose {ids[self.last]}"
        what = f"target {name} sits {self.size * 1e3:.2f} mm elsewhere from this pose on{until}"
        where = "there" if self.rest[self.first] else "before" if self.last is None else "before and after"
        done = f"its {self.rest.sum()} points {where} left out"
        return FaultFound("changed_setup", ids[self.first], name, what, done)

    def left_out(self, problem: Problem) -> Problem:
        """The problem without its points on the smaller side."""
        points = problem.campaign.points.copy()
        points[self.rest, self.target] = np.nan
        return replace(problem, campaign=replace(problem.campaign, points=points))


def reseated(result: Fit) -> Reseated | None:
    """The target that surely sits elsewhere for a part of the poses; None where none does. result: a robust
    fit of the geometry.

    What a target is off by, on its body's axes, is regressed on what the others of its body are off by: what
    moves them all as one, the robot and the instrument, goes with that. A step beside it is tried at every
    place and over every interval by Hotelling's T², which takes its noise from the target's own scatter, and
    counts each try (Bonferroni): `CHANCE` is that of any in a campaign. It must be likelier than each way to
    creep (by Akaike's measure), stand out of what may bend a bracket; and the others must not step there, as
    where the whole tool or the instrument moved. Repeats on end count as one: what a model lacks is the same
    in them. So do poses on end that hold most joints, where one rounding of these is in all of them.
    """
    problem = result.model.problem
    if problem.campaign.six_dof:
        return None
    poses = problem.campaign.poses
    alike = poses.runs if shared_rounding(result) else problem.positions
    alike = np.column_stack([alike, poses.payload])
    on, setup = np.array(problem.on), poses.setup
    found = []
    for t in np.flatnonzero(on > 0):
        others = np.flatnonzero((on == on[t]) & (np.arange(len(on)) != t))
        shared = problem.seen[:, t] & problem.seen[:, others].any(axis=1)
        for k in np.unique(setup):
            there = np.flatnonzero(shared & (setup == k))
            begins = _begins(alike[there])
            if np.count_nonzero(begins) >= 4 * FEWEST:
                also = others[problem.seen[np.ix_(there, others)].any(axis=0)]
                found.append(_Search(result, int(t), also, there, begins))
    if not found:
        return None
    likeliest = max(found, key=lambda one: one.best[0])
    return likeliest.reseated() if likeliest.chance * len(found) < CHANCE else None


class _Search:
    """The likeliest step of target t in poses (N,) of one set-up that see it and another of its body; from
    one that begins (N,) to the next they count as one."""

    def __init__(
        self,
        result: Fit,
        t: int,
        others: NDArray[np.int64],
        poses: NDArray[np.int64],
        begins: NDArray[np.bool_],
    ) -> None:
        self.problem, self.t = result.model.problem, t
        off = np.einsum("ntij,nti->ntj", result.line.target, np.nan_to_num(result.residual))[poses]
        seen = self.problem.seen[poses]
        first = np.flatnonzero(begins)
        each = np.diff(np.append(first, len(poses)))[:, None]
        self.poses = poses[first]
        self.off = np.add.reduceat(off[:, t], first) / each
        several = np.hstack([_clipped(off[:, i], seen[:, i]) for i in others])
        self.others = np.add.reduceat(several, first) / each
        self.always = np.ones((len(first), 1))
        self.beside = np.hstack([self.always, self.others])
        own = _clipped(self.off)
        shared = self.beside @ np.linalg.lstsq(self.beside, own, rcond=None)[0]
        self.clipped = shared + _clipped(own - shared)  # one wild point moves nothing
        self.best = max(self._likeliest(*_steps(len(first))), self._likeliest(*_intervals(len(first))))

    def _likeliest(self, start: NDArray[np.int64], end: NDArray[np.int64]) -> tuple[float, int, int, int]:
        """Log likelihood that the best of these intervals brings, less that of trying so many; its start, its
        end and how many."""
        share = explained(self.clipped, self.beside, start, end)[0]
        i, nu = int(np.argmax(share)), len(self.poses) - self.beside.shape[1] - 1
        likelihood = -0.5 * nu * np.log1p(-share[i]) - np.log(len(share))
        return float(likelihood), int(start[i]), int(end[i]), len(share)

    @property
    def chance(self) -> float:
        """That some step or interval of this target is as likely by chance."""
        _, start, end, tries = self.best
        return 2 * tries * self._chance(self.clipped, self.beside, start, end)

    def _chance(self, off: Array, beside: Array, start: int, end: int) -> float:
        return float(explained(off, beside, np.array([start]), np.array([end]))[1][0])

    def _likelihood(self, columns: Array) -> float:
        """Log likelihood that columns (N, m) bring beside the others, less their numbers."""
        gram = []
        for beside in (self.beside, np.hstack([self.beside, columns])):
            left = self.clipped - beside @ np.linalg.lstsq(beside, self.clipped, rcond=None)[0]
            gram.append(left.T @ left + len(left) * LEAST**2 * np.eye(3))
        less = np.linalg.slogdet(gram[0])[1] - np.linalg.slogdet(gram[1])[1]
        return float(0.5 * len(self.poses) * less - 3 * columns.shape[1])

    def reseated(self) -> Reseated | None:
        """The step; None where something smooth explains it as well, or the others step there as well."""
        _, start, end, _ = self.best
        there = np.zeros((len(self.poses), 1))
        there[start:end] = 1.0
        alone = self._likelihood(there)
        for creep in _creeping(len(self.problem.q)):
            if alone - self._likelihood(creep[self.poses]) < np.log(TIMES):
                return None
        for smooth in _smooth(self.problem, self.problem.on[self.t]):
            beside = np.hstack([self.beside, smooth[self.poses]])
            if self._chance(self.clipped, beside, start, end) > BESIDE:
                return None
        if self._chance(self.others, self.always, start, end) < BESIDE:
            return None
        columns, inside = np.hstack([self.beside, there]), there[:, 0] > 0
        own = self.off - self.others @ np.linalg.lstsq(columns, self.clipped, rcond=None)[0][1:-1]
        size = float(np.linalg.norm(np.median(own[inside], axis=0) - np.median(own[~inside], axis=0)))
        n, setup, seen = np.arange(len(self.problem.q)), self.problem.campaign.poses.setup, self.problem.seen
        bounds = np.append(self.poses, len(n))
        here = seen[:, self.t] & (setup == setup[self.poses[0]])
        inside = here & (n >= bounds[start]) & (n < bounds[end])
        rest = min(inside, here & ~inside, key=np.count_nonzero)
        last = int(bounds[end - 1]) if end < len(self.poses) else None
        return Reseated(self.t, int(bounds[start]), last, size, rest)


def _begins(alike: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(K,) the first ones of rows on end that are alike (K, m)."""
    return np.append(True, (np.diff(alike, axis=0) != 0).any(axis=1))


def explained(
    off: Array, beside: Array, start: NDArray[np.int64], end: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Share (K,) of the generalised variance of off (N, d) that a step in each of K intervals takes, fitted
    beside columns (N, m), and the chance (K,) of so large a one by Hotelling's T²."""
    U, s, _ = np.linalg.svd(beside / np.maximum(np.linalg.norm(beside, axis=0), 1e-300), full_matrices=False)
    Q = U[:, s > 1e-9 * s[0]]
    left = off - Q @ (Q.T @ off)
    d, nu = off.shape[1], len(off) - Q.shape[1] - 1
    if nu <= d:
        return np.zeros(len(start)), np.ones(len(start))
    sums, swallowed = (np.vstack([np.zeros(A.shape[1]), np.cumsum(A, axis=0)]) for A in (left, Q))
    step = sums[end] - sums[start]
    size = end - start - ((swallowed[end] - swallowed[start]) ** 2).sum(axis=1)
    own = left.T @ left + len(off) * LEAST**2 * np.eye(d)
    share = (step * np.linalg.solve(own, step.T).T).sum(axis=1) / np.maximum(size, 1.0)
    share = np.minimum(share, 1 - 1e-15)
    return share, fdtrc(d, nu - d + 1, (nu - d + 1) / d * share / (1 - share))


def _clipped(off: Array, seen: NDArray[np.bool_] | None = None) -> Array:
    """What a target is off by (N, 3), no farther from the middle than noise goes: there where not seen."""
    some = off if seen is None else off[seen]
    middle = np.median(some, axis=0)
    limit = CLIPPED * 1.4826 * np.median(np.abs(some - middle), axis=0)
    out = np.clip(off, middle - limit, middle + limit)
    return out if seen is None else np.where(seen[:, None], out, middle)


def _steps(n: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where the intervals to the end of n poses start, and their end."""
    start = np.unique(np.linspace(FEWEST, n - FEWEST, PLACES).astype(np.int64))
    return start, np.full(len(start), n)


def _intervals(n: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Start and end of the intervals that end before the last of n poses does."""
    place = np.unique(np.linspace(1, n - 1, PLACES).astype(np.int64))
    start, end = (places.ravel() for places in np.meshgrid(place, place, indexing="ij"))
    right = (end - start >= FEWEST) & (end - start <= n - FEWEST)
    return start[right], end[right]


def _creeping(n: int) -> Iterator[Array]:
    """Columns (n, m), one group for each way that a target may creep in n poses."""
    share = np.linspace(0, 1, n)[:, None]
    yield share
    yield share**2
    yield from (np.exp(-share / settling) for settling in SETTLING)
    yield np.cos(np.pi * share * np.arange(1, WAVES + 1))
    for k in range(1, WAVES):
        yield np.hstack([np.cos(np.pi * k * share), np.sin(np.pi * k * share)])


def _smooth(problem: Problem, slot: int) -> Iterator[Array]:
    """Columns (N, m), group by group, of what else may move a target bit by bit: warmth, load, how its body
    is turned, each joint."""
    q, payload = problem.q, problem.campaign.poses.payload
    if problem.warmth is not None:
        yield problem.warmth[:, None]
    turned = problem.rigid.R[slot]
    loads = [payload == load for load in np.unique(payload)[1:]]
    if loads:
        yield np.hstack([load[:, None] * np.column_stack([np.ones(len(q)), turned[:, 2]]) for load in loads])
    yield from (turned[:, axis] for axis in range(3))
    for angle, slides in zip(q.T, problem.arm.prismatic, strict=True):
        yield np.column_stack([angle, angle**2] if slides else [np.sin(angle), np.cos(angle)])
