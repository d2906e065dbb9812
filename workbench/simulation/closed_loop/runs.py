"""Runs of the closed loop as tasks: one after the other, or several at a time in processes of their own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ...correction import Conditions
from ...correction.paths import Path
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.loop import Loop
from ..processes import one_thread_each, spawn_pool
from .control import nominal_mechanics
from .mechanics import mechanics
from .motion import motion
from .simulation import STEP, run


@dataclass(frozen=True, eq=False)
class World:
    """What all runs have in common: the true robot, its loads, what is believed of both, the controller."""

    truth: Robot
    belief: Robot
    conditions: Conditions
    true_conditions: Conditions
    tool: Array | None
    loop: Loop


@dataclass(frozen=True, eq=False)
class Task:
    """One run: `q` (N, n) commanded along the path; `offset` (n,) of the encoders. said: for progress."""

    said: str
    path: Path
    q: Array
    step: float = STEP
    offset: Array | None = None


@dataclass(frozen=True, eq=False)
class Outcome:
    """Tool poses (N, 4, 4), joints (N, n) of the rigid twin, servo errors (N, n), at times (N,) [s]."""

    time: Array
    tool: Array
    q: Array
    motor: Array
    real_time_factor: float
    notes: tuple[str, ...]


def simulate(world: World, task: Task) -> Outcome:
    """One run."""
    truth = mechanics(world.truth, task.path, task.q, world.true_conditions)
    believed = mechanics(world.belief, task.path, task.q, world.conditions)
    moved = motion(task.path.time, task.q, truth.sided)
    done = run(
        truth,
        nominal_mechanics(world.belief, believed),
        moved,
        tool=world.tool,
        loop=world.loop,
        step=task.step,
        offset=task.offset,
    )
    return Outcome(moved.sample_times, done.tool, done.q, done.motor, done.real_time_factor, done.notes)


def simulate_all(
    world: World, tasks: Sequence[Task], workers: int, progress: Callable[[str], None]
) -> list[Outcome]:
    """All runs in Drake, in the order of the tasks; the same whatever `workers` (processes) is.

    progress: is told what each task has `said` as it is done.
    """
    out = []
    if workers < 2:
        for number, task in enumerate(tasks, 1):
            progress(f"run {number} of {len(tasks)}: {task.said}")
            out.append(simulate(world, task))
        return out
    with one_thread_each(), spawn_pool(workers) as pool:
        waiting = [pool.submit(simulate, world, task) for task in tasks]
        try:
            for number, (task, future) in enumerate(zip(tasks, waiting, strict=True), 1):
                out.append(future.result())
                progress(f"run {number} of {len(tasks)} done: {task.said}")
        finally:
            pool.shutdown(cancel_futures=True)  # after a failure nobody waits for the runs that did not start
    return out
