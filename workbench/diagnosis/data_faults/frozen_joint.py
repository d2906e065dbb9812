"""A joint whose readings stood still while the arm moved on: as if all points of these poses were wild."""

from __future__ import annotations

import numpy as np

from ...campaign.problem import Problem

FEWEST = 5  # poses that are left out at one reading of a joint
NEARLY_ALL, HARDLY_ANY = 0.9, 0.1  # of the poses that are left out, and of the others


def frozen_joints(measured: Problem, left: Problem) -> list[str]:
    """A remark for each joint that reads the same in nearly all poses of which nothing is left, and hardly in
    any other, while other joints move there. measured: as they were, left: without what is wild."""
    poses, still = measured.campaign.poses, left.campaign.poses
    kept = {still.ids[n] for n in np.flatnonzero(left.seen.any(axis=1))}
    lost = np.array([name not in kept for name in poses.ids]) & measured.seen.any(axis=1)
    if lost.sum() < FEWEST or lost.all():
        return []
    out = list[str]()
    moves = np.array([len(np.unique(column)) > 1 for column in poses.q[lost].T])
    for name, column in zip(measured.arm.names, poses.q.T, strict=True):
        values, counts = np.unique(column[lost], return_counts=True)
        same = column == values[counts.argmax()]
        enough = counts.max() >= max(FEWEST, NEARLY_ALL * lost.sum())
        if enough and moves.any() and same[~lost].mean() <= HARDLY_ANY:
            first, *_, last = (poses.ids[n] for n in np.flatnonzero(same & lost))
            out.append(
                f"{name} reads the same in {counts.max()} of the {lost.sum()} poses that are left out "
                f"({first} … {last}): did its readings stop while the arm moved on?"
            )
    return out
