"""A wrist joint moves with another one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Effect, Param, motion_said
from .kinds import TransmissionEffect
from .place import Where
from .unnamed.joints import Pair

UNEVEN = 0.15  # share of the motion at the ends of the other joint's range


def wrist(problem: Problem) -> list[str]:
    """Names of the last three turning joints, the robot's first joint never among them."""
    return [problem.arm.names[i] for i in np.flatnonzero(~problem.arm.prismatic)[-3:] if i > 0]


@dataclass(frozen=True)
class WristCoupling(TransmissionEffect):
    """Δq_joint = c q_other: what the controller's coupling matrix of the wrist gears leaves over.

    c is dimensionless. Wrist motors sit in the forearm and drive through concentric shafts, so that
    one joint drags the next (Stäubli RX: C[6, 5] = −1).
    """

    cause: ClassVar[str] = "wrist_coupling"
    title: ClassVar[str] = "Wrist joints are coupled"
    pure: ClassVar[bool] = True
    equation: ClassVar[str] = "Delta q_i = c thin q_j"
    separate: ClassVar[dict[str, str]] = {
        "gear_ratio": "sweep the other joint with this one at rest",
        "hose_torque": "repeat some poses with the hose pack taken off",
        "gear_eccentricity": "sweep the other joint with this one at rest",
        "wrist_coupling": "sweep one wrist joint at a time",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("coupling", "1", 1e-4, "motion of the joint per motion of the other"),)

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        return None if len(wrist(problem)) > 1 else "the robot has no wrist of two or more turning joints"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[WristCoupling]:
        names = wrist(problem)
        return [cls(Where(joint=a, other=b)) for a in names for b in names if a != b]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """The coupled gears run out a little, and drag more at some angles of the joint itself."""
        travel = float(np.ptp(problem.q[:, problem.joint(self.where.other)]))
        return [
            (UNEVEN * self.params[0].typical * travel / 2 / one.size, one)
            for one in Pair.sites(problem)
            if one.where == self.where
        ]

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        other = joints.index(str(self.where.other))
        return q[:, other : other + 1]

    def sentence(self, values: Array) -> str:
        return f"{self.where.joint} moves by {motion_said(values[0])} per rad of {self.where.other}."
