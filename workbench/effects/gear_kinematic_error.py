"""Kinematic error of a gear: cycles per motor turn, or of any other order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Effect, Param, motion_said
from .harmonics import Harmonic, amplitude_phase
from .place import Parameter, Where
from .unnamed.joints import SideBands

BANDS = 0.15  # of the amplitude, each side band: the line is 30 % stronger on one side of the turn
MANY = 10.0  # cycles per turn from which it has a strength here and there: of fewer side bands make any map


@dataclass(frozen=True)
class GearKinematicError(Harmonic):
    """Δq = a sin(k q) + b cos(k q), k = `where.order` cycles per joint turn, q in rad, a and b in rad.

    A harmonic drive errs 2 times per motor turn (k = 2 × ratio), with weaker parts at 1 and 4 times;
    motor-side run-out once (Olabi et al. 2012). `variant` is the number of cycles per motor turn; any other
    order has none. Where the gear runs out it is stronger, or ahead, on one side of the joint's turn: side
    bands one cycle per turn below and above are companions.

    Of a sliding joint k is 2π over the period in m, a and b are in m: once per turn of the pinion on its rack
    or of the screw, once per tooth.
    """

    sliding: bool = False

    cause: ClassVar[str] = "gear_kinematic_error"
    title: ClassVar[str] = "Kinematic error of a gear"
    ordered: ClassVar[bool] = True
    together: ClassVar[bool] = True
    pure: ClassVar[bool] = True  # of a gear that does not run out
    as_rounded: ClassVar[bool] = True
    equation: ClassVar[str] = "Delta q = A sin(k q + phi)"
    separate: ClassVar[dict[str, str]] = {
        "gear_kinematic_error": "sweep the joint in steps far below its shortest period",
        "gear_eccentricity": "sweep the joint in steps far below its shortest period",
        "backlash": "approach each pose from both sides",
    }

    @property
    def cycles(self) -> float:
        if self.where.order is None:
            raise ValueError("gear_kinematic_error needs an order (cycles per joint turn)")
        return self.where.order

    @property
    def local(self) -> bool:
        """An order that no ratio states is found no better than to a fraction of a cycle over the measured
        range: its phase elsewhere is anybody's guess."""
        return not self.variant

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("sin", self.unit, 3e-5), Param("cos", self.unit, 3e-5))

    @property
    def unit(self) -> str:
        return "m" if self.sliding else "rad"

    @property
    def heading(self) -> str:
        return "Error of a rack or screw that repeats" if self.sliding else self.title

    @property
    def form(self) -> str:
        return f"every {self.period_mm:.4g} mm" if self.sliding else super().form

    @property
    def period_mm(self) -> float:
        """Of a sliding joint: what it travels in one cycle."""
        return float(2e3 * np.pi / self.cycles)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[GearKinematicError]:
        """Known ratios only; other orders are found by a scan."""
        ratios = [abs(joint.data.gear_ratio or 0.0) for joint in problem.robot.joints]
        return [
            replace(one, where=replace(one.where, order=cycles * ratio), variant=str(cycles))
            for one, ratio in zip(cls._free(problem), ratios, strict=True)
            if ratio
            for cycles in (1, 2, 4)
        ]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[GearKinematicError]:
        """Orders of known ratios, and any order of a joint (order None, for `replace`)."""
        return [*cls.sites(problem), *cls._free(problem)]

    @classmethod
    def _free(cls, problem: Problem) -> list[GearKinematicError]:
        """Of each joint, without an order."""
        return [cls(Where(joint=j.name), sliding=j.kind == "prismatic") for j in problem.robot.joints]

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """A real one is not the same all around the joint's turn."""
        if self.sliding or self.cycles < MANY:
            return []
        bands = SideBands(self.where)
        return [(BANDS * self.params[0].typical / bands.params[0].typical, bands)]

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        (a, sa), (f, sf) = amplitude_phase(values, covariance)
        of = f"every {self.period_mm:.4g} mm" if self.sliding else f"of {self.cycles:g} cycles per joint turn"
        return (
            Parameter("amplitude", a, sa, self.unit, of, least=0.0),
            Parameter("phase", f, sf, "rad", "at joint zero"),
        )

    def sentence(self, values: Array) -> str:
        size = motion_said(np.hypot(*values), self.sliding)
        if self.sliding:
            turns = {"1": " (a motor turn)", "2": " (half a motor turn)", "4": " (a quarter of a motor turn)"}
            return (
                f"{self.where.joint} errs by {size} again every {self.period_mm:.4g} mm of its travel"
                f"{turns.get(self.variant, '')}: pinion and rack, screw or scale."
            )
        turns = {"1": ", once per motor turn", "2": ", twice per motor turn", "4": ", 4 times per motor turn"}
        cycles = f"{self.cycles:g} cycles per joint turn{turns.get(self.variant, '')}"
        return f"The gear of {self.where.joint} errs by {size} in {cycles}."
