"""Rows that are there twice: a copy is no second measurement."""

from __future__ import annotations

import numpy as np

from ...campaign import Campaign
from ..found import FaultFound


def without_copies(campaign: Campaign) -> tuple[Campaign, tuple[FaultFound, ...]]:
    """The campaign without poses whose joints, load, time and points are those of an earlier one to the last
    digit, be it of another campaign. Taken for repeats they would say that the robot and the instrument have
    no noise at all; taken for two campaigns, that twice as much was measured."""
    poses = campaign.poses
    columns = [poses.q, poses.payload[:, None], campaign.points.reshape(len(poses), -1)]
    if poses.time is not None:
        columns.append(poses.time[:, None])
    rows = np.concatenate([np.asarray(column, dtype=float) for column in columns], axis=1)
    _, first = np.unique(np.nan_to_num(rows, nan=np.inf), axis=0, return_index=True)
    copies = np.setdiff1d(np.arange(len(poses)), first)
    if not len(copies):
        return campaign, ()
    what = f"{len(copies)} poses are copies, to the last digit, of others (the first: {poses.ids[copies[0]]})"
    left = campaign.some(np.sort(first))
    if len(np.unique(left.poses.setup)) < len(left.setup_names):  # all of another campaign
        left = left.measured()
    return left, (FaultFound("copied_pose", None, None, what, "left out"),)
