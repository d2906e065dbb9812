"""A joint's bearing tilts under overturning moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import RX, RY, Arm, Array
from .base import Effect, Param, short
from .kinds import LinearYield
from .place import Where
from .unnamed.carriage import UnevenCarriage, at_carriage
from .unnamed.loads import UnevenTilt

UNEVEN = 0.3  # share of the tilt that is not alike in all directions
CARRIAGE = "carriage"
GUIDE = 4.0  # times as far as a turning joint's bearing: a short carriage, and the mast that it runs on


@dataclass(frozen=True)
class BearingTilt(LinearYield):
    """φ = c M for both axes across the joint's own, M the overturning moment [N·m].

    The parameter c [rad/(N·m)] comes on top of the TOML's tilt stiffness. Liu et al. share the moment
    between two bearings, TX = d₁/(d₁ + d₂) T_x.

    A ram slides in bearings that stay where they are, and tilts there. A carriage takes its bearings along
    (`variant` "carriage"): it turns about its own frame's origin, wherever it stands, about all three axes:
    none of a guide's is free to turn. Its own weight is not in M.
    """

    nominal: float = 0.0

    cause: ClassVar[str] = "bearing_tilt"
    title: ClassVar[str] = "A joint's bearing tilts"
    always: ClassVar[bool] = True
    equation: ClassVar[str] = "phi_perp = c thin M_perp"
    separate: ClassVar[dict[str, str]] = {
        "bearing_tilt": "a target on the link between the two joints",
        "link_bending": "a target on the link next to the joint",
        "foundation": "targets on the base casting",
        "joint_compliance": "a target on the link next to the joint, or a load from the side",
        "payload": "weigh what the flange carries",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        meaning = "tilt per moment, over the model's" if self.nominal else "tilt per moment"
        return (Param("compliance", "rad/(N·m)", 2e-8, meaning, lower=-self.nominal),)

    @property
    def stated(self) -> bool:
        return self.nominal > 0

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[BearingTilt]:
        """Every joint; a sliding one in both forms."""
        joints = problem.robot.joints
        stated = [joint.data.tilt_stiffness or np.inf for joint in joints]
        fixed = [cls(Where(joint=j.name), nominal=1 / k) for j, k in zip(joints, stated, strict=True)]
        return [*fixed, *(cls(Where(joint=j.name), CARRIAGE) for j in joints if j.kind == "prismatic")]

    def rarer(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """Some bearings do not yield alike in all directions, nor under any load."""
        usual = self.params[0].typical  # rad per N·m
        kind = UnevenCarriage if self.is_carriage else UnevenTilt
        uneven = [one for one in kind.sites(problem) if one.where == self.where]
        return [(UNEVEN * usual * one.largest / one.size, one) for one in uneven]

    @property
    def is_carriage(self) -> bool:
        return self.variant == CARRIAGE

    def slot(self, arm: Arm) -> int:
        """The joint's own; of a carriage the next one, which it carries along."""
        return arm.slot_of_joint(str(self.where.joint)) + self.is_carriage

    def compliance(self, arm: Arm) -> Array:
        out = np.zeros((6, 6))
        if not self.is_carriage:
            out[RX, RX] = out[RY, RY] = 1.0
            return out
        moment = at_carriage(arm, self.slot(arm))
        return np.asarray(moment.T @ moment)

    def lever(self, arm: Arm) -> float:
        return GUIDE if arm.prismatic[arm.slot_of_joint(str(self.where.joint)) - 1] else 1.0

    def sentence(self, values: Array) -> str:
        size = f"{short(values[0] * 1e9)} µrad per kN·m"
        what = "carriage" if self.is_carriage else "bearing"
        return f"The {what} of {self.where.joint} tilts by {size} more than modelled."
