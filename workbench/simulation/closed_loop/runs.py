"""Runs of the closed loop as tasks: one after the other, or several at a time in processes of their own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...correction.conditions import Conditions
from ...correction.paths import Path
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.loop import Loop
from ..processes import borrowed_pool, one_thread_each
from .cascade import Gains
from .control import nominal_mechanics
from .drives import drives
from .elastic import with_elastic_lead
from .gains import gains
from .lag import lead_hz, predicted_run, with_loop_lead
from .limits import OnLimit, OverLimit
from .mechanics import mechanics
from .motion import NO_CORNERS, Motion, motion
from .simulation import Run, first_step, run

FeedForward = Literal["static", "elastic", "loop"]
FEED_FORWARD: tuple[FeedForward, ...] = ("static", "elastic", "loop")
LARGE_CHANGE = 1e-6, 0.01  # m at most; of the error, RMS: by which half the step may move the tool
HALVINGS = 3


@dataclass(frozen=True, eq=False)
class World:
    """What all runs have in common: the simulated robot, what is believed of it, its loads, the controller;
    corners: (C,) samples in which the path turns off at once; known: the controller as the model has it,
    None: as it is."""

    truth: Robot
    belief: Robot
    conditions: Conditions
    tool: Array | None
    loop: Loop
    on_limit: OnLimit = "saturate"
    corners: NDArray[np.int64] = field(default_factory=lambda: NO_CORNERS)
    known: Loop | None = None

    @property
    def believed_loop(self) -> Loop:
        """The controller as the model has it."""
        return self.known or self.loop


@dataclass(frozen=True, eq=False)
class Task:
    """One run: `q` (N, n) commanded along the path; `offset` (n,) of the encoders; said: for progress.

    X: (N, 4, 4) desired tool poses. step: [s] of the integration, None: `first_step`. ahead: by what the
    drives lead, beside the command. settled: the step is halved until that changes little."""

    said: str
    path: Path
    q: Array
    X: Array
    step: float | None = None
    offset: Array | None = None
    ahead: FeedForward = "static"
    settled: bool = False


@dataclass(frozen=True, eq=False)
class Outcome:
    """Poses of the tool (N, 4, 4) and of base and links (N, L, 4, 4), joints (N, n), servo errors (N, n), at
    times (N,) [s].

    step: [s] of the integration; change: how far half of it moves the tool at most [m] (NaN: not tried);
    gains: of the drives."""

    time: Array
    tool: Array
    links: Array
    q: Array
    motor: Array
    notes: tuple[str, ...]
    step: float
    change: float
    gains: Gains


def simulate(world: World, task: Task) -> Outcome:
    """One run. Raises OverLimit where it is to stop at a limit."""
    truth = mechanics(world.truth, task.path, task.q, world.conditions)
    believed = mechanics(world.belief, task.path, task.q, world.conditions)
    nominal = nominal_mechanics(world.belief, believed)
    corners = world.corners[world.corners < len(task.q) - 1]
    moved = motion(task.path.time, task.q, truth.sided, corners)
    tuned = gains(truth, drives(truth, task.q[0], world.loop), world.loop, task.q)

    def at(moved: Motion, step: float) -> Run:
        return run(
            truth,
            nominal,
            moved,
            loop=world.loop,
            tuned=tuned,
            tool=world.tool,
            step=step,
            offset=task.offset,
            on_limit=world.on_limit,
        )

    step = task.step or first_step(world.loop)
    if task.ahead != "static":
        known = world.belief, task.path, task.q, world.conditions, world.tool
        moved = with_elastic_lead(moved, *known, world.believed_loop)
        if task.ahead == "loop":
            own = predicted_run(believed, nominal, moved, world.believed_loop, task.q, world.tool)
            slower = lead_hz(believed, world.believed_loop, task.q[0])
            moved = with_loop_lead(moved, *known, slower, own.tool, task.X)
    done, change = at(moved, step), float("nan")
    for _ in range(HALVINGS if task.settled else 0):
        finer = at(moved, step / 2)
        moves = np.linalg.norm(finer.tool[:, :3, 3] - done.tool[:, :3, 3], axis=1)
        error = np.linalg.norm(done.tool[:, :3, 3] - task.X[:, :3, 3], axis=1)
        change = float(moves.max())
        if change <= LARGE_CHANGE[0] and _rms(moves) <= LARGE_CHANGE[1] * _rms(error):
            break
        done, step = finer, step / 2
    else:
        if task.settled:
            done = replace(done, notes=(*done.notes, _unsettled(change)))
    return Outcome(
        moved.sample_times,
        done.tool,
        done.links,
        done.q,
        done.motor,
        done.notes,
        step,
        change,
        tuned,
    )


def _unsettled(change: float) -> str:
    return f"the simulation has not settled: half its step still moves the tool by {1e6 * change:.2g} µm"


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def simulate_all(
    world: World, tasks: Sequence[Task], workers: int, progress: Callable[[str], None]
) -> list[Outcome]:
    """All runs in Drake, in the order of the tasks; the same whatever `workers` (processes) is.

    progress: is told what each task has `said` as it is done. Raises OverLimit as `simulate` does.
    """
    out, over = simulate_to_limit(world, tasks, workers, progress)
    if over is not None:
        raise over
    return out


def simulate_to_limit(
    world: World, tasks: Sequence[Task], workers: int, progress: Callable[[str], None]
) -> tuple[list[Outcome], OverLimit | None]:
    """The same as far as no run stops at a limit, and the first that does."""
    out = list[Outcome]()
    try:
        if workers < 2:
            for number, task in enumerate(tasks, 1):
                progress(f"run {number} of {len(tasks)}: {task.said}")
                out.append(simulate(world, task))
        else:
            with one_thread_each(), borrowed_pool(workers) as pool:
                waiting = [pool.submit(simulate, world, task) for task in tasks]
                for number, (task, future) in enumerate(zip(tasks, waiting, strict=True), 1):
                    out.append(future.result())
                    progress(f"run {number} of {len(tasks)} done: {task.said}")
    except OverLimit as over:
        return out, over
    return out, None
