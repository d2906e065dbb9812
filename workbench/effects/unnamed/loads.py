"""Errors by the load on a joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import RX, Arm, Array
from ..kinds import AxialYield, YieldEffect
from ..place import Where
from .base import Unnamed


@dataclass(frozen=True)
class Torque(Unnamed, AxialYield):
    """A joint's error by its torque, even: what is odd in it is a compliance. largest [N·m, N]: torque of
    the campaign."""

    variant: str = "torque"
    largest: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "largest")

    @property
    def functions(self) -> int:
        return 2

    @property
    def variable(self) -> str:
        return f"torque of {self.where.joint}"

    @property
    def unit(self) -> str:
        return "N·m"

    def x(self, problem: Problem) -> Array:
        return _own_load(problem, problem.joint(self.where.joint))

    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        (axial,) = self.components(arm)
        x = wrench[:, axial] / self.largest
        unit, by_wrench = np.zeros((len(wrench), 6, 2)), np.zeros((len(wrench), 6, 6))
        unit[:, axial] = np.column_stack([x**2, np.abs(x)])
        by_wrench[:, axial, axial] = (2 * x * values[0] + np.sign(x) * values[1]) / self.largest
        return unit @ values, by_wrench, unit

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Torque]:
        out = []
        for j, name in enumerate(problem.arm.names):
            load = _own_load(problem, j)
            most = float(np.abs(load).max(initial=0.0))
            if np.ptp(load) > 1e-3 * max(most, 1.0):
                out.append(cls(Where(joint=name), largest=most))
        return out


@dataclass(frozen=True)
class Load(Unnamed, YieldEffect):
    """A joint's frame shifts and turns with every force and moment on it. force [N], moment [N·m]: the
    largest of the campaign. A shift's usual size is that of a turn at 0.3 m."""

    variant: str = "load"
    size: float = 5e-5
    force: float = 1.0
    moment: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "force", "moment")

    @property
    def functions(self) -> int:
        return 36

    @property
    def variable(self) -> str:
        return f"load on {self.where.joint}"

    @property
    def unit(self) -> str:
        return "N·m"

    def x(self, problem: Problem) -> Array:
        return np.linalg.norm(problem.nominal_load.local[:, self.slot(problem.arm), RX:], axis=1)

    def slot(self, arm: Arm) -> int:
        return arm.names.index(str(self.where.joint)) + 1

    def components(self, arm: Arm) -> tuple[int, ...]:
        return tuple(range(6))

    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        reach = np.array([0.3, 0.3, 0.3, 1.0, 1.0, 1.0])
        per = 1 / np.array([self.force] * 3 + [self.moment] * 3)
        C = reach[:, None] * values.reshape(6, 6) * per
        unit = np.einsum("ik,nj->nikj", np.diag(reach), wrench * per).reshape(len(wrench), 6, 36)
        return wrench @ C.T, np.broadcast_to(C, (len(wrench), 6, 6)), unit

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        out = []
        for j, name in enumerate(problem.arm.names):
            load = np.abs(problem.nominal_load.local[:, j + 1]).max(axis=0, initial=0.0)
            force, moment = float(load[:RX].max()), float(load[RX:].max())
            if min(force, moment) > 1e-3:
                out.append(cls(Where(joint=name), force=force, moment=moment))
        return out


def _own_load(problem: Problem, j: int) -> Array:
    """(N,) torque or force of a joint of the stated robot."""
    load = problem.nominal_load.local
    return np.asarray(load.reshape(len(load), -1)[:, problem.arm.axial[j]])
