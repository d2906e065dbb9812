"""The reduction ratio differs from the controller's."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Effect, Param, short
from .joint_map import JointMap
from .kinds import TransmissionEffect
from .place import Where

UNEVEN = 0.15  # share of the motion at the ends of the range
USUAL = 5e-5  # of a gear's
USUAL_SLIDING = 1.7e-4  # of a screw's lead or a rack's pitch: ISO 3408-3, grade 7, allows 52 µm in 300 mm


@dataclass(frozen=True)
class GearRatio(TransmissionEffect):
    """Δq = ε q: the joint turns (or slides) by 1 + ε of what the controller believes.

    ε is dimensionless, q counts from the joint's zero. Olabi et al. 2012, eq. (3): q_err = q_in/N − q_out.
    """

    sliding: bool = False

    cause: ClassVar[str] = "gear_ratio"
    title: ClassVar[str] = "Reduction ratio is wrong"
    smooth: ClassVar[bool] = True
    pure: ClassVar[bool] = True
    as_rounded: ClassVar[bool] = True
    wholes: ClassVar[dict[str, str]] = {"ratio": "1"}
    equation: ClassVar[str] = "Delta q = epsilon thin q"
    separate: ClassVar[dict[str, str]] = {
        "hose_torque": "repeat some poses with the hose pack taken off: on poses alone the two are the same",
        "gear_eccentricity": "sweep the joint over {range}",
        "wrist_coupling": "sweep this joint with the other wrist joints at rest",
        "gravity_compensator": "record the motor torque of the joint",
        "joint_compliance": "the same poses with another payload: a ratio does not change",
        "link_mass": "record the motor torque of the joint, or weigh the link",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        meaning = "joint travel over the commanded travel, minus one"
        usual = USUAL_SLIDING if self.sliding else USUAL
        return (Param("relative", "1", usual, meaning, lower=-5e-3, upper=5e-3),)

    @property
    def kin(self) -> Hashable:
        """One that is not the same over the range looks like a run-out or a map of the joint."""
        return "own angle", self.where.joint

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[GearRatio]:
        return [cls(Where(joint=j.name), sliding=j.kind == "prismatic") for j in problem.robot.joints]

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        j = joints.index(str(self.where.joint))
        return q[:, j : j + 1]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """A real ratio is not the same over the whole range."""
        j = problem.joint(self.where.joint)
        return JointMap.off(problem, j, UNEVEN * self.params[0].typical * float(np.ptp(problem.q[:, j])) / 2)

    def of_whole(self, problem: Problem, name: str, value: float, warmth: float) -> float | None:
        believed = problem.robot.joints[problem.joint(self.where.joint)].data.gear_ratio
        return believed / value - 1 if believed and value else None

    def sentence(self, values: Array) -> str:
        word = "further" if values[0] > 0 else "less"
        if self.sliding:
            size, what = (
                f"{short(abs(values[0]) * 1e3)} mm per m {word}",
                "the lead of its screw, its rack or its scale",
            )
        else:
            size, what = f"{short(abs(values[0]) * 1e6)} ppm {word}", "its ratio"
        return f"{self.where.joint} moves {size} than commanded: {what} is wrong."
