"""A joint's bearing tilts under overturning moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import RX, RY, Arm, Array
from .base import Effect, Param, Rest, motion_said, short
from .drawn import Drawn
from .kinds import LinearYield, SlotYield
from .place import Where
from .unnamed.carriage import UnevenCarriage, at_carriage
from .unnamed.loads import LEAST, TippingTilt, UnevenTilt

UNEVEN = 0.3  # share of the tilt that is not alike in all directions
CARRIAGE = "carriage"
PLAY = (0.02, 0.1, 0.3)  # moments from which a loose bearing has tipped over, over the campaign's largest
ALSO = 1.0  # of the play: what a loose bearing gives in proportion beside it
LOPSIDED = 0.5  # share of the play that is not alike about all axes
GUIDE = 4.0  # times as far as a turning joint's bearing: a short carriage, and the mast that it runs on


@dataclass(frozen=True)
class BearingTilt(LinearYield):
    """φ = c M for both axes across the joint's own, M the overturning moment [N·m].

    The parameter c [rad/(N·m)] comes on top of the TOML's tilt stiffness. Liu et al. share the moment
    between two bearings, TX = d₁/(d₁ + d₂) T_x.

    A bearing that is worn or loose (`variant` "play") tips over as the moment changes its side, by a [rad],
    and gives no more from a moment t₀ `torque` on: φ = a tanh(|M|/t₀) M/|M|.

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
        "link_bending": "a target on the link near its joint",
        "foundation": "targets on the base casting",
        "joint_compliance": "a target on the link near its joint, or a load from the side",
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
    def sites(cls, problem: Problem) -> Sequence[Effect]:
        """Every joint; a sliding one in both forms, a turning one that bears a moment with play as well."""
        return [*cls.even(problem), *LooseBearing.sites(problem)]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[Effect]:
        return [*cls.even(problem), *LooseBearing.places(problem)]

    @classmethod
    def even(cls, problem: Problem) -> Sequence[BearingTilt]:
        """In proportion to the moment."""
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


@dataclass(frozen=True)
class LooseBearing(SlotYield):
    """Play of a bearing, as `BearingTilt` has it."""

    variant: str = "play"
    torque: float = 1.0

    cause: ClassVar[str] = BearingTilt.cause
    title: ClassVar[str] = BearingTilt.title
    rare: ClassVar[bool] = True
    equation: ClassVar[str] = "phi_perp = a tanh(|M_perp| \\/ t_0) thin M_perp \\/ |M_perp|"
    settings: ClassVar[tuple[str, ...]] = ("torque",)
    separate: ClassVar[dict[str, str]] = BearingTilt.separate

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("amplitude", "rad", 5e-5, "tilt of the play, to either side", lower=0.0),)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[LooseBearing]:
        """Turning joints that bear a moment."""
        loaded = {str(one.where.joint): one.largest for one in TippingTilt.sites(problem)}
        return [
            replace(place, torque=place.torque * loaded[str(place.where.joint)])
            for place in cls.places(problem)
            if loaded.get(str(place.where.joint), 0.0) > LEAST
        ]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[LooseBearing]:
        """With a `torque` of so many shares of 1 N·m: a model.toml states its own."""
        joints = [joint.name for joint in problem.robot.joints if joint.kind != "prismatic"]
        return [cls(Where(joint=name), f"play {share:g}", share) for name in joints for share in PLAY]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """What is worn gives in proportion to the moment as well, and not alike about all axes."""
        (here,) = (one for one in BearingTilt.even(problem) if one.where == self.where)
        tips = [one for one in TippingTilt.sites(problem) if one.where == self.where]
        even = [replace(one, most=self.torque / one.largest) for one in tips]
        return [(ALSO, here), *((LOPSIDED, one) for one in even)]

    def slot(self, arm: Arm) -> int:
        return arm.slot_of_joint(str(self.where.joint))

    def components(self, arm: Arm) -> tuple[int, ...]:
        return (RX, RY)

    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        M = wrench[:, RX : RY + 1]
        size = np.maximum(np.linalg.norm(M, axis=1), 1e-9 * self.torque)
        tipped = np.tanh(size / self.torque)
        share, slope = tipped / size, ((1 - tipped**2) / self.torque - tipped / size) / size**2
        motion, by_value = np.zeros((len(M), 6)), np.zeros((len(M), 6, 1))
        by_wrench = np.zeros((len(M), 6, 6))
        by_value[:, RX : RY + 1, 0] = share[:, None] * M
        motion[:, RX : RY + 1] = values[0] * by_value[:, RX : RY + 1, 0]
        across = slope[:, None, None] * M[:, :, None] * M[:, None, :]
        by_wrench[:, RX : RY + 1, RX : RY + 1] = values[0] * (share[:, None, None] * np.eye(2) + across)
        return motion, by_wrench, by_value

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """Over the moment that tips it."""
        wrench = rest.load.local[:, self.slot(rest.arm)]
        size = np.linalg.norm(self.law(rest.arm, wrench, values)[0], axis=1)
        load = np.linalg.norm(wrench[:, RX : RY + 1], axis=1)
        name = str(self.where.joint)
        return Drawn(load, f"overturning moment at {name}", "N·m", size, f"tilt of {name}", "rad")

    def sentence(self, values: Array) -> str:
        return (
            f"The bearing of {self.where.joint} has play: it tips by {motion_said(abs(values[0]))} to either "
            f"side, and carries from about {short(self.torque)} N·m on."
        )
