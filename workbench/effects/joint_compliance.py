"""Axial stiffness of a joint differs from the model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array
from .base import Effect, Param, Rest, grouped
from .drawn import Drawn
from .kinds import AxialYield, LinearYield, YieldEffect
from .place import ALL, Where
from .unnamed.curved_yield import CurvedYield
from .unnamed.loads import Torque

ONE_SIDED = 0.15  # of the yield, that depends on the torque's sign
RIGID = 0.01  # of the model's compliance: below that a fit tells it from none on no robot
CURVED = 0.2  # of the yield, that is not in proportion to the torque


@dataclass(frozen=True)
class JointCompliance(AxialYield, LinearYield):
    """Δq = c₀ · relative · τ, with c₀ = 1/K of the model; Δq = c · τ where the model is rigid; with one
    `relative` for all joints, where a whole table of stiffnesses is off by a factor (`variant` "all").

    τ is the joint's torque from gravity, payload, wrench and compensator. Jiao et al. 2020,
    eqs. (5), (9).
    """

    nominal: float = 0.0
    sliding: bool = False

    cause: ClassVar[str] = "joint_compliance"
    title: ClassVar[str] = "Joint stiffness differs from the model"
    always: ClassVar[bool] = True
    wholes: ClassVar[dict[str, str]] = {"stiffness": "N·m/rad"}
    equation: ClassVar[str] = "Delta q = c_0 thin r thin tau"
    separate: ClassVar[dict[str, str]] = {
        "payload": "weigh what the flange carries, or add a third load",
        "link_mass": "measure with two payloads: a stiffness acts on both, a link mass on neither",
        "link_bending": "a target on the link near its joint",
        "bearing_tilt": "a target on the link near its joint, or a load from the side",
        "lost_motion": "a third load, one that reverses the torque",
        "gravity_compensator": "record the motor torque of the joint",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        if self.nominal > 0:
            meaning = "compliance of the joint over the model's, minus one"
            return (Param("relative", "1", 0.3, meaning, lower=-1.0),)
        unit = "m/N" if self.sliding else "rad/(N·m)"
        meaning = "compliance of the joint, which the model has rigid"
        return (Param("compliance", unit, 1e-6, meaning, lower=0.0),)

    @property
    def stated(self) -> bool:
        return self.nominal > 0

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[YieldEffect]:
        """Every joint by itself, and all together."""
        return [*cls.each(problem), *ArmCompliance.sites(problem)]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[YieldEffect]:
        return [*cls.each(problem), *ArmCompliance.places(problem)]

    @classmethod
    def each(cls, problem: Problem) -> list[JointCompliance]:
        """Every joint by itself."""
        return [
            cls(Where(joint=joint.name), "", 1 / (joint.data.stiffness or np.inf), joint.kind == "prismatic")
            for joint in problem.robot.joints
        ]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """A real joint yields more to one side than to the other."""
        return self._shares(problem, ONE_SIDED, Torque)

    def rarer(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """Of some joints the yield is not in proportion to the torque."""
        return self._shares(problem, CURVED, CurvedYield)

    def _shares(self, problem: Problem, share: float, kind: type[Torque]) -> list[tuple[float, Effect]]:
        """A share of the usual yield, as much of a function of this joint's torque."""
        usual = self.nominal * self.params[0].typical  # rad per N·m
        return [
            (share * (usual * one.largest / one.size if self.stated else 2.0), one)
            for one in kind.sites(problem)
            if one.where == self.where
        ]

    def compliance(self, arm: Arm) -> Array:
        (axial,) = self.components(arm)
        out = np.zeros((6, 6))
        out[axial, axial] = self.nominal or 1.0
        return out

    def of_whole(self, problem: Problem, name: str, value: float, warmth: float) -> float | None:
        if value <= 0:
            return None
        return 1 / (self.nominal * value) - 1 if self.nominal > 0 else 1 / value

    def sentence(self, values: Array) -> str:
        if self.nominal > 0:
            left = 1 + float(values[0])  # of the model's compliance
            whole = self._stiffness(self.nominal * left)
            if left < RIGID:
                has = self._stiffness(self.nominal)
                return f"{self.where.joint} is as good as rigid, where the model has it yield{has}."
            if left < 0.5:
                return f"{self.where.joint} is {1 / left:.3g} times as stiff as in the model{whole}."
            word, less = ("softer", "less") if left > 1 else ("stiffer", "more")
            change = 100 * abs(1 / left - 1)
            return f"{self.where.joint} is {word} than the model: {change:.1f} % {less} stiffness{whole}."
        unit = "µm per N" if self.sliding else "µrad per N·m"
        whole = self._stiffness(float(values[0]))
        return f"{self.where.joint} yields {values[0] * 1e6:.3g} {unit}{whole}; the model has it rigid."

    def _stiffness(self, compliance: float) -> str:
        """The whole, as tables of stiffness have it; empty of a joint that yields nothing."""
        unit = "N/m" if self.sliding else "N·m/rad"
        if compliance <= 0:
            return ""
        return f" ({grouped(1 / compliance, 3)} {unit})"


@dataclass(frozen=True)
class ArmCompliance(YieldEffect):
    """The form of the whole arm: every one of its `joints` with c₀ · (1 + relative), alike in all."""

    variant: str = ALL
    joints: tuple[JointCompliance, ...] = ()

    cause: ClassVar[str] = JointCompliance.cause
    title: ClassVar[str] = JointCompliance.title
    called: ClassVar[str] = "compliance of all joints alike"
    equation: ClassVar[str] = JointCompliance.equation
    separate: ClassVar[dict[str, str]] = JointCompliance.separate
    in_proportion: ClassVar[bool] = True

    @property
    def params(self) -> tuple[Param, ...]:
        meaning = "compliance of all joints over the model's, minus one"
        return (Param("relative", "1", 0.3, meaning, lower=-1.0),)

    @property
    def stated(self) -> bool:
        return True

    @property
    def parts(self) -> Sequence[JointCompliance]:
        return self.joints

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[ArmCompliance]:
        """Where gravity alone pulls: forces from outside show each joint by itself, and are off by some
        hundredths in their own right."""
        return [] if problem.campaign.poses.wrench.any() else cls.places(problem)

    @classmethod
    def places(cls, problem: Problem) -> Sequence[ArmCompliance]:
        """Where the model states a stiffness of more joints than one."""
        joints = tuple(one for one in JointCompliance.each(problem) if one.stated)
        return [cls(joints=joints)] if len(joints) > 1 else []

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        return [pair for joint in self.joints for pair in joint.companions(problem)]

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """Of the joint that moves most by it."""
        each = [joint.drawn(problem, rest, values) for joint in self.joints]
        return max(each, key=lambda one: float(np.abs(one.size).max(initial=0.0)))

    def sentence(self, values: Array) -> str:
        left = 1 + float(values[0])  # of the model's compliance
        if left < RIGID:
            return "All joints are as good as rigid, where the model has them yield."
        return f"All joints are {1 / left:.3g} times as stiff as in the model."
