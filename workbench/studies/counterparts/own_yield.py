"""A joint's yield under its own torque, as the robot's sensor read it or else as gravity makes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...effects.base import Acts, Depends, Param, Rest
from ...effects.drawn import Drawn
from ...effects.kinds import DirectEffect
from ...effects.place import Where
from ...robot.kinematics import Array


@dataclass(frozen=True)
class OwnYield(DirectEffect):
    """Δq = c τ of one joint, while its angle is within low ≤ q < high [rad].

    τ: the joint's sensor where the campaign has one, else the torque of gravity on the robot as stated. It
    is a number of the pose, so that masses the robot's file does not know do no harm.
    """

    low: float = -np.inf
    high: float = np.inf

    cause: ClassVar[str] = "joint_compliance"
    title: ClassVar[str] = "Joint yields under its own torque"
    acts: ClassVar[Acts] = "transmission"
    depends: ClassVar[Depends] = frozenset({"load"})

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("compliance", "rad/(N·m)", 1e-6, "compliance of the joint"),)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[OwnYield]:
        return [cls(Where(joint=name)) for name in problem.arm.names]

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        j = problem.joint(self.where.joint)
        within = (self.low <= problem.q[:, j]) & (problem.q[:, j] < self.high)
        return {int(problem.arm.axial[j]): np.where(within, torque(problem)[:, j], 0.0)[:, None]}

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        own, name = torque(problem)[:, problem.joint(self.where.joint)], str(self.where.joint)
        return Drawn(own, f"torque of {name}", "N·m", values[0] * own, f"error of {name}", "rad")


def torque(problem: Problem) -> Array:
    """(N, n) [N·m, N] of the joints: sensed, or of gravity where no sensor was read."""
    gravity = problem.nominal_torque
    sensed = problem.campaign.poses.torque
    return gravity if sensed is None else np.where(np.isfinite(sensed), sensed, gravity)
