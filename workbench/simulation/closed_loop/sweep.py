"""Error by tool speed: where the static correction ends, and what feed-forward of the deflection adds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...correction.command import compensate
from ...correction.paths import Path
from ...robot.description import Robot
from ...robot.kinematics import Array
from .measures import shares
from .motion import path_speed
from .runs import Outcome, Task, World, simulate_all
from .verification import Sweep
from .ways import Way

SWEEP_SPEEDS = (0.01, 0.03, 0.1, 0.3, 0.6, 1.0)  # m/s
LONGEST = 30.0  # s that a run of the sweep may take in the simulated world: the path is cut there


def swept(
    world: World,
    way: Way,
    path: Path,
    commands: dict[str, Array],
    workers: int,
    progress: Callable[[str], None],
) -> Sweep:
    """The corrected and the uncorrected path at all speeds, and on an arm that does not yield.

    commands: (M, n) joints of each variant along the way. Drives over their limits saturate.
    """
    world = replace(world, on_limit="saturate")
    stiff = rigid(world.truth)
    alone = replace(world, truth=stiff, belief=stiff)
    still = compensate(stiff, path, world.conditions, tool=world.tool, start=commands["uncorrected"][0])
    stiffly = way.command(still.q_command)
    along, X = way.along(path), way.X
    elastic, rigids, cut = [], [], None
    for speed in SWEEP_SPEEDS:
        timed, kept = _at(along, X, speed)
        cut = LONGEST if kept < len(X) else cut
        for name, ahead in (("uncorrected", "static"), ("corrected", "static"), ("corrected", "elastic")):
            said = f"{speed:g} m/s, {ahead} feed-forward, {name}"
            elastic.append(Task(said, timed, commands[name][:kept], X[:kept], ahead=ahead))  # type: ignore[arg-type]
        rigids.append(Task(f"{speed:g} m/s, rigid", timed, stiffly[:kept], X[:kept]))
    done = simulate_all(world, elastic, workers, progress)
    left = [_rms(outcome, task) for outcome, task in zip(done, elastic, strict=True)]
    floor = [
        _rms(outcome, task)
        for outcome, task in zip(simulate_all(alone, rigids, workers, progress), rigids, strict=True)
    ]
    names = ("uncorrected", "corrected", "elastic")
    return Sweep(
        np.array(SWEEP_SPEEDS),
        {"rigid": np.array(floor)} | {name: np.array(left[i::3]) for i, name in enumerate(names)},
        cut,
    )


def rigid(robot: Robot) -> Robot:
    """The same robot with nothing that yields: no stiffness, no effects."""
    joints = tuple(
        replace(joint, data=joint.data.model_copy(update={"stiffness": None, "tilt_stiffness": None}))
        for joint in robot.joints
    )
    return replace(robot, joints=joints, bending_stiffness={}, effects=())


def _at(path: Path, X: Array, speed: float) -> tuple[Path, int]:
    """The path at a tool speed, cut where it would last too long, and how many samples are left of it."""
    p, time = X[:, :3, 3], path.time
    timed = (time - time[0]) * path_speed(p, time) / speed
    kept = max(int(np.searchsorted(timed, LONGEST)), 2)
    along = {
        name: None if value is None else value[:kept]
        for name, value in (
            ("q", path.q),
            ("X", path.X),
            ("wrench", path.wrench),
            ("temperature", path.temperature),
        )
    }
    return replace(path, time=timed[:kept], **along), kept  # type: ignore[arg-type]


def _rms(outcome: Outcome, task: Task) -> float:
    """[mm] each sample counted by the time that it stands for, as in the table of speeds."""
    error = outcome.tool[:, :3, 3] - task.X[:, :3, 3]
    return float(1e3 * np.sqrt(shares(task.path.time) @ (error**2).sum(axis=1)))
