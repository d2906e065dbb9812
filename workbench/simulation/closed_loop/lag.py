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
from .drives import drives
from .gains import gains
from .machine import machine
from .mechanics import Mechanics
from .modes import frequencies
from .motion import Motion, interpolated, slow_part
from .simulation import Run, first_step, run

PERIOD = 0.004  # s of the lead's grid
OF_LOWEST_MODE = 0.5  # as fast as that part of it a lead may be


def predicted_run(
    believed: Mechanics, nominal: Mechanics, moved: Motion, loop: Loop, q: Array, tool: Array | None
) -> Run:
    """The believed robot's run under the controller that the model states, with gains made for both.
    q: (N, n) joints along the path; tool: (4, 4) in the flange frame."""
    tuned = gains(believed, drives(believed, q[0], loop), loop, q)
    step = first_step(loop)
    return run(believed, nominal, moved, loop=loop, tuned=tuned, tool=tool, step=step, on_limit="saturate")


def lead_hz(believed: Mechanics, loop: Loop, q: Array) -> float:
    """[Hz] up to which a lead removes what it is made for: what is faster excites the arm's lowest mode,
    drives locked, at joints q (n,)."""
    built = machine(believed, drives(believed, q, loop))
    if not len(built.springs):
        return loop.feed_forward_hz
    lowest = float(frequencies(built, q, free=False)[0]) / (2 * np.pi)
    return min(loop.feed_forward_hz, OF_LOWEST_MODE * lowest)


def with_loop_lead(
    moved: Motion,
    belief: Robot,
    path: Path,
    q: Array,
    conditions: Conditions,
    tool: Array | None,
    slower_than: float,
    predicted: Array,
    wanted: Array,
) -> Motion:
    """The motion with the predicted error of the tool taken off.

    predicted, wanted: (N, 4, 4) tool poses at the path's samples. What is not slower than `lead_hz` [Hz]
    stays.
    """
    trajectory = trajectory_of(belief, replace(path, q=q, X=None), conditions, tool)
    error = np.empty((len(q), 6))
    error[:, :3] = wanted[:, :3, 3] - predicted[:, :3, 3]
    error[:, 3:] = vectors(wanted[:, :3, :3] @ predicted[:, :3, :3].swapaxes(1, 2))
    change = np.einsum("kij,kj->ki", trajectory.gain(slice(None)), trajectory.tip.scaled(error))
    t = np.append(np.arange(0.0, moved.duration, PERIOD), moved.duration)
    return moved.ahead(t, slow_part(interpolated(t, moved.sample_times, change), slower_than, PERIOD))
