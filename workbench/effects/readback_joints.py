"""The read-back joints are nearer to the truth than the commanded ones, or further."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Acts, Depends, Param, Rest
from .drawn import Drawn
from .kinds import DirectEffect


@dataclass(frozen=True)
class ReadbackJoints(DirectEffect):
    """Δq = w (r − q) of every joint, r read back, q commanded; w = 1: the arm is where r says,
    w = 0: where the command says. An empty cell of r counts as the command.

    Static error of the servo (P-gain, dead band), or an encoder that reads wrongly.
    """

    cause: ClassVar[str] = "readback_joints"
    title: ClassVar[str] = "Read-back joints"
    acts: ClassVar[Acts] = "transmission"
    depends: ClassVar[Depends] = frozenset({"readback"})
    equation: ClassVar[str] = "Delta q = w thin (r - q)"
    separate: ClassVar[dict[str, str]] = {
        "joint_compliance": "wait longer before each reading; the same pose with another payload",
        "backlash": "approach each pose from both sides, and read the joints back",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("weight", "1", 1.0, "0: the arm is where commanded, 1: where read back"),)

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        n = problem.arm.n
        if problem.campaign.poses.readback is None:
            return f"no columns r1..r{n}: read the joints back at each pose"
        return None if cls.sites(problem) else f"r1..r{n} equal the command at every pose"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[ReadbackJoints]:
        return cls.places(problem) if np.abs(_difference(problem)).max(initial=0.0) > 0 else []

    @classmethod
    def places(cls, problem: Problem) -> Sequence[ReadbackJoints]:
        return [cls()]

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        difference = _difference(problem)
        return {int(c): difference[:, j : j + 1] for j, c in enumerate(problem.arm.axial)}

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        apart = np.linalg.norm(_difference(problem), axis=1)
        return Drawn(
            apart, "read back minus commanded", "rad", values[0] * apart, "error of the joints", "rad"
        )

    def sentence(self, values: Array) -> str:
        if values[0] > 0.5:
            return (
                f"The arm is where the joints were read back (weight {values[0]:.2f}), not where commanded."
            )
        return f"The read-back joints are no better than the commanded ones (weight {values[0]:.2f})."


def _difference(problem: Problem) -> Array:
    """r − q (N, n) [rad, m], zero where nothing was read."""
    readback = problem.campaign.poses.readback
    if readback is None:
        return np.zeros_like(problem.q)
    return np.where(np.isfinite(readback), readback - problem.q, 0.0)
