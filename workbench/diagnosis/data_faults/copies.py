"""Rows that are there twice: a copy is no second measurement."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import pdtrc

from ...campaign import Campaign
from ...robot.kinematics import Array
from ..found import FaultFound

BY_CHANCE = 1e-3  # that as many repeats are alike to the last digit, from which they are repeats
ROUNDS = 50


def without_copies(campaign: Campaign) -> tuple[Campaign, tuple[FaultFound, ...]]:
    """The campaign without poses whose joints, load, time and points are those of an earlier one to the last
    digit, be it of another campaign. Taken for repeats they would say that the robot and the instrument have
    no noise at all; taken for two campaigns, that twice as much was measured. Repeats that are read as
    roughly as they scatter are alike now and then."""
    poses = campaign.poses
    columns = [poses.q, poses.payload[:, None], campaign.points.reshape(len(poses), -1)]
    if poses.time is not None:
        columns.append(poses.time[:, None])
    rows = np.concatenate([np.asarray(column, dtype=float) for column in columns], axis=1)
    _, first = np.unique(np.nan_to_num(rows, nan=np.inf), axis=0, return_index=True)
    copies = np.setdiff1d(np.arange(len(poses)), first)
    if not len(copies) or _alike_by_chance(campaign, len(copies)):
        return campaign, ()
    what = f"{len(copies)} poses are copies, to the last digit, of others (the first: {poses.ids[copies[0]]})"
    left = campaign.some(np.sort(first))
    if len(np.unique(left.poses.setup)) < len(left.setup_names):  # all of another campaign
        left = left.measured()
    return left, (FaultFound("copied_pose", None, None, what, "left out"),)


def _alike_by_chance(campaign: Campaign, count: int) -> bool:
    """Whether so many repeats may well be alike in all their numbers, by how often others are in single
    ones."""
    points = campaign.points.reshape(len(campaign.poses), -1)
    first, second = (points[own] for own in _repeats(campaign))
    both = np.isfinite(first) & np.isfinite(second)
    numbers, alike = both.sum(axis=1), ((first == second) & both).sum(axis=1)
    other = alike < numbers
    if not other.any():
        return False
    in_single = alike[other].sum() / numbers[other].sum()
    each, most = in_single, numbers[other].mean()
    for _ in range(ROUNDS):  # those that are alike in all numbers are not among these
        each = in_single * (1 - each**most) + each**most
    expected = float((each ** numbers[numbers > 0]).sum())
    return bool(pdtrc(count - 1, expected) > BY_CHANCE)


def _repeats(campaign: Campaign) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(K,) poses, and (K,) the next of each one's joints and load, be it of another campaign."""
    poses = campaign.poses
    rows: Array = np.concatenate([poses.q, np.asarray(poses.payload, dtype=float)[:, None]], axis=1)
    group = np.unique(rows, axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(group, kind="stable")
    next_to = group[order[1:]] == group[order[:-1]]
    return order[:-1][next_to], order[1:][next_to]
