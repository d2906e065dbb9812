"""Gear eccentricity: one or two cycles per joint turn."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Effect, Param, motion_said
from .harmonics import Harmonic, amplitude_phase
from .joint_map import JointMap
from .place import Parameter, Where

OTHER, HIGHER = 0.3, 0.1  # shares of the amplitude: half and twice as many cycles, whatever else


@dataclass(frozen=True)
class GearEccentricity(Harmonic):
    """Δq = a sin(k q) + b cos(k q), k = 1 or 2 cycles per joint turn (`variant`); of 2 there may be 4 beside.

    Run-out of the output gear or of an encoder on the output.
    """

    cause: ClassVar[str] = "gear_eccentricity"
    title: ClassVar[str] = "Gear eccentricity"
    smooth: ClassVar[bool] = True
    together: ClassVar[bool] = True
    pure: ClassVar[bool] = True  # an encoder's is
    as_rounded: ClassVar[bool] = True
    equation: ClassVar[str] = "Delta q = A sin(k q + phi), quad k in {1, 2}"
    separate: ClassVar[dict[str, str]] = {
        "gear_ratio": "sweep the joint over {range}",
        "gravity_compensator": "record the motor torque of the joint (3 % is enough), or add loads",
        "joint_compliance": "the same poses with another payload: eccentricity does not change",
        "link_mass": "record the motor torque of the joint, or weigh the link",
        "foundation": "targets on the base casting",
    }

    @property
    def cycles(self) -> int:
        return int(self.variant or 1)

    @property
    def params(self) -> tuple[Param, ...]:
        # more than 3 mrad of run-out is no gear: it would be a function of q that something else causes
        return tuple(Param(name, "rad", 1e-4, lower=-3e-3, upper=3e-3) for name in ("sin", "cos"))

    @property
    def kin(self) -> Hashable:
        """A map of the joint can look like it, as far as anybody knows how either looks."""
        return "own angle", self.where.joint

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[GearEccentricity]:
        return cls._over(problem, ("1", "2"))

    @classmethod
    def places(cls, problem: Problem) -> Sequence[GearEccentricity]:
        return cls._over(problem, ("1", "2", "4"))  # the last beside the second: no run-out by itself

    @classmethod
    def _over(cls, problem: Problem, variants: Sequence[str]) -> list[GearEccentricity]:
        """Of all joints that turn."""
        arm = problem.arm
        turning = [name for name, sliding in zip(arm.names, arm.prismatic, strict=True) if not sliding]
        return [cls(Where(joint=name), variant) for name in turning for variant in variants]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """A real run-out has twice as many cycles as well, and of two one; and a little of all others."""
        harmonics: dict[int, Sequence[str]] = {1: ("2",), 2: ("1", "4")}
        others = JointMap.off(problem, problem.joint(self.where.joint), HIGHER * self.params[0].typical)
        return [*((OTHER, replace(self, variant=one)) for one in harmonics.get(self.cycles, ())), *others]

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        (a, sa), (f, sf) = amplitude_phase(values, covariance)
        cycles = "1 cycle" if self.cycles == 1 else f"{self.cycles} cycles"
        return (
            Parameter("amplitude", a, sa, "rad", f"of {cycles} per joint turn", least=0.0),
            Parameter("phase", f, sf, "rad", "at joint zero"),
        )

    def sentence(self, values: Array) -> str:
        size = motion_said(np.hypot(*values))
        often = {1: "once", 2: "twice"}.get(self.cycles, f"{self.cycles} times")
        return f"The gear of {self.where.joint} runs out {often} per turn, by {size}."
