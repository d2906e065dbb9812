"""A joint does not yield in proportion to its torque."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..base import motion_said
from .loads import Torque


@dataclass(frozen=True)
class CurvedYield(Torque):
    """A gear grows stiffer, or softer, with its torque, alike to both sides: the next odd polynomials beside
    the straight line (Legendre's, of third and fifth degree, over the campaign's largest torque)."""

    variant: str = "curved yield"

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        x = self.x(problem) / self.largest
        column = int(problem.arm.axial[problem.joint(self.where.joint)])
        third, fifth = (5 * x**3 - 3 * x) / 2, (63 * x**5 - 70 * x**3 + 15 * x) / 8
        return {column: np.column_stack([third, fifth])}

    def sentence(self, values: Array) -> str:
        size = motion_said(float(np.abs(values).max()))
        return f"It does not yield in proportion to its torque: what is off is {size}."
