"""Stretches of poses whose points belong to other poses: a row too few or too many in one of the tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..found import FaultFound

FEWEST = 3  # poses that are found at others: two may be chance
NEAR = 10.0  # times what points are usually off: their own place


def shifted_poses(problem: Problem, predicted: Array, length: Array, limit: Array) -> tuple[FaultFound, ...]:
    """Poses whose points are all grossly off and together at the place of another such pose. predicted:
    (N, T, 3), length, limit: (N, T) [m]."""
    c, seen = problem.campaign, problem.seen
    wild = seen & (length > limit)
    gross = np.flatnonzero(wild.any(axis=1) & (wild == seen).all(axis=1))
    if len(gross) < FEWEST or not (seen & ~wild).any():
        return ()
    near = NEAR * float(np.median(length[seen & ~wild]))
    at = _places(c.points[gross], predicted[gross], near)
    there = np.flatnonzero(at >= 0)
    if len(there) < FEWEST:
        return ()
    rows = gross[there]
    by, count = np.unique(gross[at[there]] - rows, return_counts=True)
    most = int(by[np.argmax(count)])
    others = {-1: "the pose before", 1: "the pose after"}.get(most, "another pose")
    ids = [c.poses.ids[n] for n in rows]
    what = f"points fit the joints of {others}: pose_id is mixed up between poses {ids[0]} and {ids[-1]}"
    return tuple(FaultFound("shifted_pose", name, None, what, "left out; mend pose_id there") for name in ids)


def _places(points: Array, predicted: Array, near: float) -> NDArray[np.int64]:
    """(G,) at which other of G poses the points (G, T, 3) of each are, -1 where at none. predicted: (G, T, 3)
    where they would be."""
    off = np.linalg.norm(points[:, None] - predicted[None], axis=-1)
    worst = np.max(np.where(np.isfinite(off), off, 0.0), axis=2)
    np.fill_diagonal(worst, np.inf)
    return np.asarray(np.where(worst.min(axis=1) < near, worst.argmin(axis=1), -1))


def without_shifted(problem: Problem, faults: tuple[FaultFound, ...]) -> Problem:
    """The problem without the points of those poses."""
    names = {fault.pose_id for fault in faults}
    wrong = np.array([name in names for name in problem.campaign.poses.ids])
    points = np.where(wrong[:, None, None], np.nan, problem.campaign.points)
    return replace(problem, campaign=replace(problem.campaign, points=points))
