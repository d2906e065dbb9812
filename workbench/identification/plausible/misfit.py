"""How far the measured points are from where the rigid robot has them, over the spread of the points.

Of points that the robot keeps in one place while its joints move (a ball in a socket, a hand that turns about
its tool), that spread says nothing: there it is the one that these joints give when each has its values in an
order of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from ...robot.kinematics import Arm, Array, Frames, frames
from ..registration import STATED_TARGET, UNKNOWN_TARGET, Placed, middle_of, place, sight, spread_of

POSES = 60  # of a set-up, evenly chosen: enough to tell a wrong robot
SETUPS = 6
SMALLEST = 5  # poses of a set-up that its own frame and targets do not explain whatever they are
USUAL = 0.03  # m, how far from the truth people state a target
BOUND = 0.1  # of the spread, from which on a point counts no more: a few wild ones do not decide


@dataclass(frozen=True)
class Sample:
    """Some poses of every set-up, to be explained. q: (N, n), points: (N, T, 3), setup: (N,); stated: (T, 3)
    places of the targets behind their slots, NaN where unknown, `on` these slots; rows: (N,) and
    targets: (T,) which poses and targets of the campaign."""

    rows: NDArray[np.int64]
    targets: tuple[int, ...]
    arm: Arm
    q: Array
    points: Array
    setup: NDArray[np.int64]
    stated: Array
    on: tuple[int, ...]

    @cached_property
    def where(self) -> Frames:
        """The frames of its joints."""
        return frames(self.arm, self.q)

    @cached_property
    def in_any_order(self) -> Frames:
        """The frames of its joints where each has its values in an order of its own."""
        return frames(self.arm, np.random.default_rng(len(self.q)).permuted(self.q, axis=0))

    def changed(self, **parts: Any) -> Sample:
        """The same with other parts."""
        return replace(self, **parts)

    def only(self, some: NDArray[np.int64]) -> Sample:
        """Some of its poses."""
        return replace(
            self, rows=self.rows[some], q=self.q[some], points=self.points[some], setup=self.setup[some]
        )


@dataclass(frozen=True)
class Misfit:
    """Over the spread of the points, share: bounded rms misfit; middle: the median one; displaced: how far
    targets are from where they are stated, beyond what people measure wrong. spread [m].

    placed: every set-up that was looked at.
    """

    share: float = 0.0
    middle: float = 0.0
    displaced: float = 0.0
    spread: float = 0.0
    placed: tuple[Placed, ...] = ()

    @property
    def total(self) -> float:
        """Of points and targets together."""
        return math.hypot(self.share, self.displaced)


def sample(problem: Problem) -> Sample:
    """The poses that are looked at, and the targets that move."""
    setup = problem.campaign.poses.setup
    moving = [i for i, slot in enumerate(problem.on) if slot > 0] or list(range(len(problem.on)))
    some = problem.seen[:, moving].any(axis=1)
    chosen = [np.zeros(0, dtype=np.int64)]
    for k in np.unique(setup):
        here = np.flatnonzero((setup == k) & some)
        if len(here) >= SMALLEST and len(chosen) <= SETUPS:
            chosen.append(here[np.unique(np.linspace(0, len(here) - 1, POSES).round().astype(np.int64))])
    rows = np.concatenate(chosen)
    on = tuple(problem.on[i] for i in moving)
    points = problem.campaign.points[rows][:, moving]
    stated = problem.stated_targets[moving]
    return Sample(rows, tuple(moving), problem.arm, problem.q[rows], points, setup[rows], stated, on)


def held(data: Sample) -> Array:
    """(T,) [m] how far each target may be from where it is stated."""
    return np.where(np.isfinite(data.stated).all(axis=1), STATED_TARGET, UNKNOWN_TARGET)


def misfit(data: Sample, *, turns: bool = False, scale: bool = False, rounds: int = 40) -> Misfit:
    """Misfit of a sample after every set-up was placed for itself with its targets. turns: from 24 more
    directions; scale: the size of the points is free as well; rounds: iterations."""
    known, prior = np.isfinite(data.stated).all(axis=1), held(data)
    placed, lengths, spreads, displaced = [], [np.zeros(0)], [], 0.0
    for k in np.unique(data.setup):
        seen = sight(data.where, data.points, data.on, data.setup == k)
        found = place(seen, data.stated, prior, turns=turns, scale=scale, rounds=rounds)
        points = seen.p + np.einsum("ntij,tj->nti", seen.R, found.targets)
        moved = data.in_any_order.points(found.targets, data.on)
        spread = found.scale * max(spread_of(points[seen.seen]), spread_of(moved.reshape(-1, 3))) + 1e-9
        placed.append(found)
        spreads.append(spread)
        lengths.append(found.length[np.isfinite(found.length)] / spread)
        good = known & (_middle(found.length) < BOUND * spread)
        off = np.linalg.norm((found.targets - data.stated)[good], axis=1)
        displaced = max(displaced, *(np.maximum(off - USUAL, 0.0) / spread), 0.0)
    every = np.concatenate(lengths)
    if not len(every):
        return Misfit()
    share = float(np.sqrt(np.mean(np.minimum(every, BOUND) ** 2)))
    return Misfit(share, float(middle_of(every)), float(displaced), float(np.median(spreads)), tuple(placed))


def _middle(length: Array) -> Array:
    """(T,) median of each target's (N, T) lengths, infinite where it was never seen."""
    seen = [column[np.isfinite(column)] for column in length.T]
    return np.array([middle_of(some) if len(some) else np.inf for some in seen])
