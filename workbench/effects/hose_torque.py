"""The hose pack pulls on a wrist joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array, Frames
from ..robot.loads import Loads
from .base import Effect, Param, Rest
from .drawn import Drawn
from .joint_map import JointMap
from .kinds import LoadEffect
from .place import Where
from .wrist_coupling import wrist

UNEVEN = 0.2  # share of the motion at the ends of the range


@dataclass(frozen=True)
class HoseTorque(LoadEffect):
    """τ = −k q on the joint: hoses and cables act as a spring about the joint's zero.

    k in N·m/rad; q is the commanded joint. It shows through the joint's compliance, and so is the
    twin of a gear ratio error on poses alone.
    """

    cause: ClassVar[str] = "hose_torque"
    title: ClassVar[str] = "Hose pack pulls on a joint"
    nearly: ClassVar[bool] = True  # a spring: else all that look like one are taken for a wrong ratio
    equation: ClassVar[str] = "tau = -k thin q"
    separate: ClassVar[dict[str, str]] = {
        "gear_ratio": "repeat some poses with the hose pack taken off, or record the motor torque",
        "wrist_coupling": "repeat some poses with the hose pack taken off",
        "gear_eccentricity": "repeat some poses with the hose pack taken off, or record the motor torque",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("rate", "N·m/rad", 10.0, "torque against the joint, per rad from its zero", lower=0.0),)

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        if cls.sites(problem):
            return None
        return "no wrist joint has a stiffness: state it in the robot's TOML, or record the drives' torques"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[HoseTorque]:
        """Wrist joints that yield; a rigid one shows a torque in its drive's alone."""
        stiff = {joint.name for joint in problem.robot.joints if joint.data.stiffness is None}
        return [cls(Where(joint=name)) for name in wrist(problem) if problem.drives or name not in stiff]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """A real hose is no spring: it stiffens, sticks and lies on."""
        j = problem.joint(self.where.joint)
        stiffness = problem.robot.joints[j].data.stiffness
        if stiffness is None:
            return ()
        torque = self.params[0].typical * float(np.ptp(problem.q[:, j])) / 2
        return JointMap.off(problem, j, UNEVEN * torque / stiffness)

    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        j = problem.joint(self.where.joint)
        torque = loads.torque.copy()
        torque[:, j] -= values[0] * problem.q[:, j]
        return arm, replace(loads, torque=torque)

    def wrench(self, problem: Problem, where: Frames, loads: Loads) -> Array:
        j = problem.joint(self.where.joint)
        out = np.zeros((len(problem.q), 6 * problem.arm.slots, 1))
        out[:, problem.arm.axial[j], 0] = -problem.q[:, j]
        return out.reshape(len(problem.q), problem.arm.slots, 6, 1)

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        j = problem.joint(self.where.joint)
        return self.drawn_over_joint(problem, j, -values[0] * problem.q[:, j])

    def sentence(self, values: Array) -> str:
        return f"The hose pack pulls {self.where.joint} back with {values[0]:.1f} N·m per rad."
