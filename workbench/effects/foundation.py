"""The base turns under overturning moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import RX, RY, Arm, Array
from .base import Effect, Param, short
from .kinds import LinearYield
from .unnamed.loads import UnevenTilt

UNEVEN = 0.3  # share of the tilt that is not alike in all directions


@dataclass(frozen=True)
class Foundation(LinearYield):
    """φ = c M about both axes of the floor, M the overturning moment at the base's origin [N·m].

    c in rad/(N·m): pedestal, anchors, floor.
    """

    cause: ClassVar[str] = "foundation"
    title: ClassVar[str] = "The foundation yields"
    equation: ClassVar[str] = 'phi_"base" = c thin M_"base"'
    separate: ClassVar[dict[str, str]] = {
        "bearing_tilt": "targets on the base casting",
        "link_bending": "targets on the base casting",
        "gear_eccentricity": "targets on the base casting",
        "joint_compliance": "targets on the base casting",
        "drift": "return to some poses at other times",
        "payload": "weigh what the flange carries",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("compliance", "rad/(N·m)", 3e-9, "tilt of the base per moment", lower=0.0),)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Foundation]:
        return [cls()]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """No ground is alike in all directions, nor as stiff under any load."""
        return [(UNEVEN, one) for one in UnevenTilt.sites(problem) if one.where == self.where]

    def slot(self, arm: Arm) -> int:
        return 0

    def compliance(self, arm: Arm) -> Array:
        out = np.zeros((6, 6))
        out[RX, RX] = out[RY, RY] = 1.0
        return out

    def sentence(self, values: Array) -> str:
        return f"The base tilts by {short(values[0] * 1e9)} µrad per kN·m of overturning moment."
