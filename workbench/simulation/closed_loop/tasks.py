"""The runs that `verify` is made of: what settles the step, the other commands, the repeats."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...correction.paths import Path
from ...robot.description import Robot
from ...robot.kinematics import Array
from .runs import FeedForward, Outcome, Task
from .verification import COMMAND_NAMES, speed_text


def settling(X: Array, timed: list[tuple[Path, float]], commands: list[dict[str, Array]]) -> list[Task]:
    """The corrected path at each speed, which settles the step for the others."""
    return [
        Task(f"corrected by everything, {speed_text(speed)}", p, q["corrected"], X, settled=True)
        for (p, speed), q in zip(timed, commands, strict=True)
    ]


def others(
    X: Array,
    timed: list[tuple[Path, float]],
    commands: list[dict[str, Array]],
    settled: list[Outcome],
    extra: Sequence[FeedForward],
) -> list[Task]:
    """All other commands at each speed; `extra` ones are the corrected command with drives that lead."""
    tasks = []
    for (p, speed), variants, first in zip(timed, commands, settled, strict=True):
        for name, q in variants.items():
            if name != "corrected":
                said = f"{COMMAND_NAMES[name].lower()}, {speed_text(speed)}"
                tasks.append(Task(said, p, q, X, step=first.step))
        for name in extra:
            said = f"{name} feed-forward, {speed_text(speed)}"
            tasks.append(Task(said, p, variants["corrected"], X, step=first.step, ahead=name))
    return tasks


def repeated(
    truth: Robot, like: Task, commands: dict[str, Array], count: int, seed: int
) -> list[Task]:  # fmt: skip
    """Runs with the joints off by what their repeatability says."""
    sigma = truth.repeatability
    if not sigma.any() or count < 2:
        return []
    offsets = sigma * np.random.default_rng([seed, 11]).normal(size=(count, len(sigma)))
    return [
        Task(
            f"{COMMAND_NAMES[name].lower()}, repeat {i} of {count}",
            like.path,
            commands[name],
            like.X,
            step=like.step,
            offset=offset,
        )
        for name in ("uncorrected", "corrected")
        for i, offset in enumerate(offsets, 1)
    ]
