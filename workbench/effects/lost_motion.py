"""The stiffness of a joint depends on its torque: soft zone, hardening, play."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array
from .base import Param, motion_said, short
from .kinds import AxialYield
from .place import Where

SOFT = (0.05, 0.15, 0.5)  # width of the soft zone, as shares of the joint's largest torque
PLAY = 0.02


@dataclass(frozen=True)
class LostMotion(AxialYield):
    """Δq beyond τ/K, odd in the joint's torque τ [N·m], by `variant`:

    soft   Δq = a tanh(τ/t₀): the gear yields a [rad] more until its teeth carry at t₀ `torque`
    play   the same with t₀ = 2 % of the largest torque: the joint falls to either side
    cubic  Δq = a (τ/t₀)³, a at the largest torque t₀; a < 0: the gear hardens

    The sites' t₀ are shares of the largest nominal torque in the campaign; one that is accepted is moved to
    where the data want it.
    """

    torque: float = 1.0
    sliding: bool = False
    stated: bool = field(default=True, kw_only=True, compare=False, repr=False)  # the joint's stiffness

    cause: ClassVar[str] = "lost_motion"
    title: ClassVar[str] = "Stiffness depends on torque"
    equation: ClassVar[str] = "Delta q = a tanh(tau \\/ t_0)"
    settings: ClassVar[tuple[str, ...]] = ("torque",)
    separate: ClassVar[dict[str, str]] = {
        "joint_compliance": "three loads at each pose, one of which reverses the torque",
        "payload": "weigh what the flange carries, or measure a third load",
        "gravity_compensator": "a load that reverses the torque; the motor torque of the joint",
        "backlash": "each pose from both sides, under the same load",
        "gear_eccentricity": "the same poses with another payload",
        "link_mass": "the same poses with another payload, or weigh the link",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        unit = "m" if self.sliding else "rad"
        if self.variant == "cubic":
            return (Param("amplitude", unit, 5e-5, "more than linear, at the largest torque"),)
        return (Param("amplitude", unit, 5e-5, "yield of the soft zone, to either side", lower=0.0),)

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        if cls.sites(problem):
            return None
        return "no joint carries any torque: state masses in the URDF, or measure with a payload"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[LostMotion]:
        """Joints that carry load at all."""
        torque, least = _largest_torque(problem)
        carries = dict(zip(problem.arm.names, torque > least, strict=True))
        return [place for place in cls.places(problem) if carries[str(place.where.joint)]]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[LostMotion]:
        arm = problem.arm
        shares = {**{f"soft {share:g}": share for share in SOFT}, "play": PLAY, "cubic": 1.0}
        torque, least = _largest_torque(problem)
        torque = np.where(torque > least, torque, 1.0)  # any: a model.toml states its own
        return [
            cls(
                Where(joint=joint.name), variant, share * float(torque[j]), bool(arm.prismatic[j]),
                stated=joint.data.stiffness is not None,
            )
            for j, joint in enumerate(problem.robot.joints)
            for variant, share in shares.items()
        ]  # fmt: skip

    def finer(self) -> Sequence[LostMotion]:
        """The same soft zone, narrower and wider."""
        if not self.variant.startswith("soft"):
            return ()
        return [replace(self, torque=float(self.torque * x)) for x in np.geomspace(0.4, 2.5, 15)]

    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        (axial,) = self.components(arm)
        x = wrench[:, axial] / self.torque
        if self.variant == "cubic":
            form, slope = x**3, 3 * x**2
        else:
            form = np.tanh(x)
            slope = 1 - form**2
        motion = np.zeros((len(wrench), 6))
        by_wrench = np.zeros((len(wrench), 6, 6))
        by_value = np.zeros((len(wrench), 6, 1))
        motion[:, axial] = values[0] * form
        by_wrench[:, axial, axial] = values[0] * slope / self.torque
        by_value[:, axial, 0] = form
        return motion, by_wrench, by_value

    def sentence(self, values: Array) -> str:
        size = motion_said(abs(values[0]), self.sliding)
        load = f"{short(self.torque)} {'N' if self.sliding else 'N·m'}"
        if self.variant == "cubic":
            word = "softens" if values[0] > 0 else "hardens"
            return f"{self.where.joint} {word} with load: {size} at {load}."
        if self.variant == "play":
            return f"{self.where.joint} falls {size} to either side as its torque changes sign."
        return f"{self.where.joint} has a soft zone: {size} to either side, below about {load}."


def _largest_torque(problem: Problem) -> tuple[Array, float]:
    """(n,) largest nominal torque of each joint in the campaign [N·m, N], and what counts as none."""
    local = problem.nominal_load.local
    torque = np.abs(problem.arm.own(local)).max(axis=0)
    return torque, 1e-6 * float(np.abs(local).max(initial=1e-6))
