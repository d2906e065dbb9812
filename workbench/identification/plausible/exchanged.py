"""Targets whose names are exchanged at a part of the poses: seen by the distances between them.

Targets on one body keep their distances, whatever the pose, the frame and the robot.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, permutations

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from .hypotheses import MOST_ORDERS, Hypothesis
from .misfit import Sample

SHOWN = 3  # poses by their ids


def exchanged_names(problem: Problem) -> Iterator[Hypothesis]:
    """That names are exchanged at some poses, where the distances of three targets or more show at which."""
    c = problem.campaign
    moving = [i for i, slot in enumerate(problem.on) if slot > 0]
    if len(moving) < 3 or len({problem.on[i] for i in moving}) > 1:
        return
    order = _orders(c.points[:, moving], problem.stated_targets[moving])
    ways, one = np.unique(order, axis=0), np.arange(len(moving))
    if (ways == one).all(axis=1).any():
        ways = one[None]
    # where no pose is as stated, the places are not known that well: at some way the names are right
    for way in ways if len(ways) < len(order) else ():
        yield from _exchanged(problem, moving, order[:, np.argsort(way)])


def _exchanged(problem: Problem, moving: list[int], order: NDArray[np.int64]) -> Iterator[Hypothesis]:
    """That the names of targets `moving` are exchanged where an order of (N, T) is not theirs."""
    c = problem.campaign
    wrong = np.flatnonzero((order != np.arange(len(moving))).any(axis=1))
    if not 0 < len(wrong) < len(order):
        return
    mixed = [c.targets[i].name for k, i in enumerate(moving) if (order[:, k] != k).any()]
    ids = [c.poses.ids[n] for n in wrong]
    at = ", ".join(ids[:SHOWN]) + (f" … {ids[-1]}" if len(ids) > SHOWN else "")
    names = f"{', '.join(mixed[:-1])} and {mixed[-1]}"

    def undo(data: Sample) -> Sample:
        return data.changed(points=np.take_along_axis(data.points, order[data.rows][..., None], axis=1))

    what = f"the names of the targets {names} are exchanged at {len(wrong)} of {len(order)} poses ({at})"
    yield Hypothesis("points", what, "exchange them there in the column target", undo)


def _orders(points: Array, stated: Array) -> NDArray[np.int64]:
    """(N, T) order of each pose's targets in which their distances are those of the stated places, or, where
    these are not known, of the middle pose. points: (N, T, 3), stated: (T, 3) [m], NaN where not known."""
    count = points.shape[1]
    orders = np.array(list(islice(permutations(range(count)), MOST_ORDERS)))
    apart = np.linalg.norm(points[:, :, None] - points[:, None], axis=-1)
    seen = np.flatnonzero(np.isfinite(apart).all(axis=(1, 2)))
    out = np.tile(np.arange(count), (len(points), 1))
    if not len(seen):
        return out
    usual = np.linalg.norm(stated[:, None] - stated[None], axis=-1)
    if not np.isfinite(usual).all():
        usual = apart[seen[len(seen) // 2]]
    # the first order is the one as they are named: it stays where another is no better
    off = [np.abs(apart[seen][:, o[:, None], o] - usual).sum(axis=(1, 2)) for o in orders]
    out[seen] = orders[np.argmin(off, axis=0)]
    return out
