"""Correction of the commanded path by what the controller's own model predicts of its lag.

The believed robot runs the path in the simulated loop first; what its tool is then off the path, servo lag
and all, is taken off the command through the nominal arm's inverse Jacobian.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...correction.conditions import Conditions
from ...correction.paths import Path
from ...correction.trajectory import trajectory_of
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.loop import Loop
from ...robot.rotations import vectors
from .motion import Motion, interpolated, slow_part

PERIOD = 0.004  # s of the lead's grid


def with_loop_lead(
    moved: Motion,
    belief: Robot,
    path: Path,
    q: Array,
    conditions: Conditions,
    tool: Array | None,
    loop: Loop,
    predicted: Array,
    wanted: Array,
) -> Motion:
    """The motion with the predicted error of the tool taken off.

    predicted, wanted: (N, 4, 4) tool poses at the path's samples. What is faster than `feed_forward_hz`
    stays: it would excite what it is to remove.
    """
    trajectory = trajectory_of(belief, replace(path, q=q, X=None), conditions, tool)
    error = np.empty((len(q), 6))
    error[:, :3] = wanted[:, :3, 3] - predicted[:, :3, 3]
    error[:, 3:] = vectors(wanted[:, :3, :3] @ predicted[:, :3, :3].swapaxes(1, 2))
    change = np.einsum("kij,kj->ki", trajectory.gain(slice(None)), trajectory.tip.scaled(error))
    t = np.append(np.arange(0.0, moved.duration, PERIOD), moved.duration)
    return moved.ahead(
        t, slow_part(interpolated(t, moved.sample_times, change), loop.feed_forward_hz, PERIOD)
    )
