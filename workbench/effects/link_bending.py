"""A link bends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.beam import bending_compliance
from ..robot.kinematics import RX, Arm, Array
from .base import Effect, Param
from .bearing_tilt import BearingTilt
from .kinds import LinearYield
from .place import Where
from .unnamed.link_ends import OfLink, OwnWeight, PivotForce, UnevenBending

UNEVEN = 0.3  # of the bending: a section that is twice as stiff in one direction
SHORTEST = 0.05  # m, shorter links are taken as rigid


@dataclass(frozen=True)
class LinkBending(LinearYield):
    """A cantilever from joint to joint under the force F and moment M at its end, over its length l:

    w = (F l³/3 + M l²/2)/EI,  turn = (F l²/2 + M l)/EI, both across the link.

    The parameter is 1/EI [1/(N·m²)], over the model's where the TOML states a bending stiffness. The
    link's own weight counts at its joints only; what it bends the link by itself, spread along it as nobody
    knows, is a companion. Liu et al., eqs. (15)–(20).
    """

    nominal: float = 0.0

    cause: ClassVar[str] = "link_bending"
    title: ClassVar[str] = "A link bends"
    shifts: ClassVar[bool] = True
    load_name: ClassVar[str] = "bending load F l³/3 + M l²/2"
    load_unit: ClassVar[str] = "N·m³"
    equation: ClassVar[str] = "w = (F l^3 \\/ 3 + M l^2 \\/ 2) \\/ E I"
    separate: ClassVar[dict[str, str]] = {
        "joint_compliance": "a target in the middle of the link, or loads in two directions",
        "bearing_tilt": "targets at both ends of the link",
        "gravity_compensator": "the motor torque of joint 2, or a target in the middle of the link",
        "foundation": "targets on the base casting",
        "payload": "weigh what the flange carries",
        "link_bending": "a target in the middle of each link",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        meaning = "1/EI of the link, over the model's" if self.nominal else "1/EI of the link"
        return (Param("compliance", "1/(N·m²)", 2e-8, meaning, lower=-self.nominal),)

    @property
    def stated(self) -> bool:
        return self.nominal > 0

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[LinkBending]:
        """Moving links longer than 5 cm."""
        arm, stated = problem.arm, problem.robot.bending_stiffness
        return [
            cls(Where(link=arm.links[k]), nominal=1 / stated.get(arm.links[k], np.inf))
            for k in range(1, arm.n + 1)
            if np.linalg.norm(arm.span[k + 1]) > SHORTEST
        ]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """A real link gives way at its bearings as well, under its own weight, wherever that is, and under
        more or less of the compensator's force."""
        arm, slot = problem.arm, self.slot(problem.arm)
        ends = [name for k, name in enumerate(arm.names, start=1) if k in (slot - 1, slot)]
        tilts = [one for one in BearingTilt.sites(problem) if one.where.joint in ends]
        every: list[OfLink] = [*OwnWeight.sites(problem), *PivotForce.sites(problem)]
        own = [one for one in every if one.where == self.where]
        return [*((0.3, one) for one in tilts), *((self._share(problem, one), one) for one in own)]

    def rarer(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """Some links do not bend alike in all directions."""
        uneven = [one for one in UnevenBending.sites(problem) if one.where == self.where]
        return [(UNEVEN * self._usual(problem, one), one) for one in uneven]

    def _usual(self, problem: Problem, uneven: OfLink) -> float:
        """What a link usually bends by, over the usual size of what is uneven of that."""
        if self.stated:
            return self.params[0].typical * uneven.largest / uneven.size
        return self.lever(problem.arm)

    def _share(self, problem: Problem, own: OfLink) -> float:
        """What a link's own weight or the compensator bends it by, over the usual size of that, where the
        link is as soft as is usual; no more than what hangs on it does."""
        if self.stated:
            return self.params[0].typical * own.largest / own.size
        loads = problem.nominal_load.local[:, self.slot(problem.arm)]
        ends = loads @ self.compliance(problem.arm)[:RX].T
        return own.largest / max(float(np.linalg.norm(ends, axis=1).max(initial=0.0)), own.largest)

    def slot(self, arm: Arm) -> int:
        return arm.slot_of_link(str(self.where.link)) + 1

    def compliance(self, arm: Arm) -> Array:
        return bending_compliance(arm.span[self.slot(arm)])

    def lever(self, arm: Arm) -> float:
        """What its end moves by where the line from its root to it tilts by 1 rad [m]: the link's length."""
        return float(np.linalg.norm(arm.span[self.slot(arm)]))

    def sentence(self, values: Array) -> str:
        total = values[0] + self.nominal
        if total <= 0:
            return f"{self.where.link} does not bend."
        return f"{self.where.link} bends: its stiffness EI is {1 / total:.2g} N·m²."
