"""A gas spring between two links of an arm: what it does to a joint's torque and to its stiffness.

The pivots P0 (on the body) and P1 (on the moving link) and the joint's axis P2 make a triangle with the
sides a = P0P2 and L = P1P2, and s = P0P1 changes with the joint (Klimchik et al. 2017, eqs. (2)–(7), with
φ = α − q: with this sign torque and stiffness are derivatives of one energy):

    s² = a² + L² + 2aL cos φ,   s′ = ds/dq = (aL/s) sin φ,   s″ = −(aL/s) cos φ − (aL sin φ)²/s³

The spring pulls the pivots together with F(s): torque on the moving link −F s′, stiffness F′ s′² + F s″.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...effects.base import Param
from ...effects.gravity_compensator import GravityCompensator
from ...effects.kinds import LoadEffect
from ...robot.compensator import CompensatorLaw
from ...robot.kinematics import Arm, Array, Frames
from ...robot.loads import Loads


@dataclass(frozen=True)
class Linkage:
    """The triangle of a compensator: sides a and L [m], α [rad]."""

    a: float
    L: float
    alpha: float

    def stretch(self, q: Array) -> tuple[Array, Array, Array]:
        """s [m], s′ [m/rad], s″ [m/rad²] at joint angles q (N,) [rad]."""
        phi, aL = self.alpha - q, self.a * self.L
        s = np.sqrt(self.a**2 + self.L**2 + 2 * aL * np.cos(phi))
        return s, aL * np.sin(phi) / s, -aL * np.cos(phi) / s - (aL * np.sin(phi)) ** 2 / s**3


def linkage(arm: Arm, law: CompensatorLaw) -> Linkage:
    """The triangle of an arm's compensator, whose pivots sit on neighbouring links."""
    turn = arm.R[law.arm]
    axis = turn[:, 2]
    sides = law.body_pivot - arm.p[law.arm], turn @ law.arm_pivot
    to_body, to_arm = (v - axis * (axis @ v) for v in sides)
    angle = np.arctan2(axis @ np.cross(to_arm, to_body), to_arm @ to_body)  # P1–P2–P0 at q = 0
    a, L = float(np.linalg.norm(to_body)), float(np.linalg.norm(to_arm))
    return Linkage(a, L, float(np.mod(angle + np.pi, 2 * np.pi)))


def bias(triangle: Linkage, law: CompensatorLaw, q: Array) -> Array:
    """Torque (N,) [N·m] of the compensator on the moving link at joint angles q (N,), eqs. (3), (6)."""
    s, slope, _ = triangle.stretch(q)
    return -law.force(s)[0] * slope


def added_stiffness(triangle: Linkage, law: CompensatorLaw, q: Array) -> Array:
    """Stiffness (N,) [N·m/rad] that the compensator adds to the joint at angles q (N,), eq. (7)."""
    s, slope, bend = triangle.stretch(q)
    force, rate, _ = law.force(s)
    return rate * slope**2 + force * bend


@dataclass(frozen=True)
class GasLength(LoadEffect):
    """The compensator's gas column l = V/A is longer than the model's by `relative`: the tank's volume.

    It says how fast the force grows with s, where the charge says how large it is. Not in the catalogue:
    it is asked for where a compensator itself is identified.
    """

    cause: ClassVar[str] = GravityCompensator.cause
    title: ClassVar[str] = "Gas volume of the compensator differs from the model"

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("gas_length", "1", 0.05, "gas length over the model's, minus one", lower=-1.0),)

    @classmethod
    def sites(cls, problem: Problem) -> list[GasLength]:
        law = problem.compensator
        return [cls(variant="gas_length")] if law is not None and law.data.kind == "gas" else []

    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        law = loads.compensator
        assert law is not None
        assert law.data.gas_length
        data = law.data.model_copy(update={"gas_length": law.data.gas_length * (1 + float(values[0]))})
        return arm, replace(loads, compensator=replace(law, data=data))

    def wrench(self, problem: Problem, where: Frames, loads: Loads) -> Array:
        law = loads.compensator
        assert law is not None
        assert law.data.gas_length
        assert law.data.reference is not None
        assert problem.compensator is not None
        assert problem.compensator.data.gas_length
        s = law.ends(where)[2]
        length, ds = law.data.gas_length, s - law.data.reference
        # dF/dl over dF/dcharge, per unit of the relative length
        share = -law.charge * law.data.exponent * problem.compensator.data.gas_length * ds
        share = share / (length * (length - ds))
        charge = GravityCompensator(variant="charge", kind="gas").wrench(problem, where, loads)
        return np.asarray(charge * np.asarray(share)[:, None, None, None])
