"""Poses at which another wrench pulled than written, as a slip of the pen has it, seen in how far the arm
yields there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.file import WRENCH_COLUMNS
from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..found import FaultFound
from .mistaken_wrenches import under
from .other_loads import NEARER, Predicts, farthest

POINTS = 2  # of a pose at least: one that is off may be off as a wrench has it
PLACE = 10.0  # times: a decimal point
ALONE = 0.5  # of how far off the next best is


def pulled_as_fits(
    problem: Problem, predicted: Array, limit: Array, at: Predicts
) -> tuple[Problem, tuple[FaultFound, ...]]:
    """The problem with poses that are farther than `limit` (N, T) [m] from where they are predicted (N, T, 3)
    under the slip of a wrench that brings them most of the way, and no other nearly so near, and which.
    at: predicts them under other wrenches."""
    c = problem.campaign
    off = farthest(problem, np.linalg.norm(c.points - predicted, axis=2) / limit)
    far = (off > 1.0) & (problem.seen.sum(axis=1) >= POINTS)
    if not c.poses.wrench.any() or not far.any():
        return problem, ()
    slips = list(_slips(c))
    left = np.full((len(slips), len(off)), np.inf)
    for k, (_, wrench) in enumerate(slips):
        with suppress(ArithmeticError):
            away = np.linalg.norm(at(under(problem, wrench)) - c.points, axis=2)
            left[k] = farthest(problem, away / limit)
    left[:, ~far] = np.inf
    best = left.argmin(axis=0)
    nearest = left.min(axis=0)
    others = np.where([(wrench == _of_each(slips, best)).all(axis=1) for _, wrench in slips], np.inf, left)
    wrong = np.flatnonzero((nearest < NEARER * off) & (nearest < ALONE * others.min(axis=0)))
    wrench, faults = c.poses.wrench.copy(), []
    for n in wrong.tolist():
        said, meant = slips[best[n]]
        wrench[n] = meant[n]
        what = f"the points fit {said}, not as written"
        faults.append(FaultFound("wrong_wrench", c.poses.ids[n], None, what, "taken so"))
    return under(problem, wrench), tuple(faults)


def _of_each(slips: Sequence[tuple[str, Array]], chosen: NDArray[np.int64]) -> Array:
    """(N, 6) of each pose the wrench of the slip that is chosen for it."""
    return np.stack([slips[k][1][n] for n, k in enumerate(chosen.tolist())])


def _slips(c: Campaign) -> Iterator[tuple[str, Array]]:
    """What may have been meant in each pose (N, 6), in words."""
    wrench, names = c.poses.wrench, [column.name for column in WRENCH_COLUMNS]
    yield "a wrench the other way round", -wrench
    yield "no wrench", np.zeros_like(wrench)
    yield "the wrench of the next pose", np.concatenate([wrench[1:], wrench[-1:]])
    yield "the wrench of the pose before", np.concatenate([wrench[:1], wrench[:-1]])
    for k in np.flatnonzero(wrench.any(axis=0)).tolist():
        for factor, how in ((-1.0, "the other way round"), (PLACE, "ten times"), (1 / PLACE, "a tenth of")):
            meant = wrench.copy()
            meant[:, k] *= factor
            yield f"{how} {names[k]}" if factor > 0 else f"{names[k]} {how}", meant
