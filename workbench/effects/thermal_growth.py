"""The links grow with temperature, or while the robot warms up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import REFERENCE_TEMPERATURE, Problem
from ..robot.kinematics import Array
from .base import Depends, Param, Rest, short
from .coming_to_rest import SHARES, share_gone, start_and_span
from .drawn import Drawn
from .kinds import DirectEffect
from .place import Where

ALUMINIUM, STEEL = 23e-6, 11.5e-6  # 1/K
SCALE = "scale"
MOST = 1e-3  # relative growth of aluminium that warms by 40 K: no arm warms up by more


@dataclass(frozen=True)
class ThermalGrowth(DirectEffect):
    """Δp = α (T − 20 °C) p for the fixed length p of every link (steel: α = 11.5e-6/K).

    Without thermometer, `variant` "warmup": Δp = a (1 − exp(−(t − t₀)/t_c)) p, a the growth at the end;
    t₀ `start` and t_c `constant` in s. Uniform growth of the whole arm.

    What a sliding joint travels is measured by its own rack, screw or scale, which grows from where it is
    held (`variant` "scale", at that joint): Δq = (T − 20 °C) (α q + β), −β/α where it is held.
    """

    start: float = 0.0
    constant: float = 0.0

    cause: ClassVar[str] = "thermal_growth"
    title: ClassVar[str] = "Links grow with temperature"
    depends: ClassVar[Depends] = frozenset({"temperature", "time"})
    bounded: ClassVar[bool] = True
    equation: ClassVar[str] = "Delta p = alpha thin (T - T_0) thin p"
    settings: ClassVar[tuple[str, ...]] = ("start", "constant")
    separate: ClassVar[dict[str, str]] = {
        "drift": "four targets on the base, measured every ten minutes",
        "tracker_scale": "a scale bar, or two fixed targets of known distance",
        "gravity_compensator": "{gauge}, cold and warm",
        "thermal_growth": "one posture of the arm along the whole travel, cold and warm",
        "gear_ratio": "one posture of the arm along the whole travel, cold and warm",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        if self.of_scale:
            return (
                Param(
                    "coefficient", "1/K", 1e-5, "relative growth of the scale per K", lower=0.0, upper=1e-4
                ),
                Param("shift", "m/K", 1e-5, "motion at the joint's zero per K"),
            )
        if self.variant.startswith("warmup"):
            what = "relative growth at the end, inferred from time alone"
            return (Param("coefficient", "1", 1e-4, what, lower=-MOST, upper=MOST),)
        return (
            Param("coefficient", "1/K", 1e-5, "relative growth of the links per K", lower=0.0, upper=1e-4),
        )

    @property
    def of_scale(self) -> bool:
        return self.variant == SCALE

    @property
    def heading(self) -> str:
        return "A rack or scale grows with temperature" if self.of_scale else self.title

    @property
    def uses(self) -> Depends:
        return frozenset({"time" if self.variant.startswith("warmup") else "temperature"})

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        if problem.warmth is None and problem.time is None:
            return "no column temp_degC (or t_s): record the temperature of the arm with each pose"
        if not cls.sites(problem):
            return "temp_degC (or t_s) is the same for all poses: measure cold and warm"
        return None

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[ThermalGrowth]:
        every = cls.places(problem)
        by_temperature = [one for one in every if "temperature" in one.uses]
        by_time = [one for one in every if "time" in one.uses]
        if problem.warmth is not None:
            return by_temperature if np.ptp(problem.warmth) > 0 else []
        return by_time if problem.time_passes else []

    @classmethod
    def places(cls, problem: Problem) -> Sequence[ThermalGrowth]:
        start, span = start_and_span(problem)
        return [
            cls(),
            *(cls(variant=f"warmup {share:g}", start=start, constant=share * span) for share in SHARES),
            *(cls(Where(joint=name), SCALE) for name in cls._sliding(problem)),
        ]

    @staticmethod
    def _sliding(problem: Problem) -> list[str]:
        arm = problem.arm
        return [name for name, slides in zip(arm.names, arm.prismatic, strict=True) if slides]

    def _warmth(self, problem: Problem) -> Array | None:
        if not self.variant.startswith("warmup"):
            return problem.warmth
        if problem.time is None:
            return None
        return share_gone(problem.time - self.start, self.constant)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        warmth, span = self._warmth(problem), problem.arm.span
        if warmth is None:
            return {}
        if self.of_scale:
            j = problem.joint(self.where.joint)
            return {int(problem.arm.axial[j]): np.column_stack([warmth * problem.q[:, j], warmth])}
        return {
            6 * slot + c: warmth[:, None] * span[slot, c]
            for slot in range(problem.arm.slots)
            for c in range(3)
            if abs(span[slot, c]) > 1e-9
        }

    @classmethod
    def unmeasured(cls, problem: Problem, kelvin: Array, found: bool) -> Mapping[int, Array]:
        """Every link, rack and scale is of one metal or another, whatever the arm grows by in the mean; where
        nobody knows that, it is with 95 % less than if all were of aluminium."""
        arm, apart, common = problem.arm, (ALUMINIUM - STEEL) / 2, 0.0 if found else ALUMINIUM / 1.96
        slides = np.flatnonzero(arm.prismatic).tolist()
        parts = np.eye(arm.slots + len(slides))
        out = {
            6 * slot + c: kelvin[:, None] * arm.span[slot, c] * np.append(apart * parts[slot], common)
            for slot in range(arm.slots)
            for c in range(3)
        }
        for part, j in zip(parts[arm.slots :], slides, strict=True):
            grown = (kelvin * problem.q[:, j])[:, None] * np.append(apart * part, common)
            out[int(arm.axial[j])] = out[int(arm.axial[j])] + grown
        return out

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        warmth = self._warmth(problem)
        growth = np.zeros(len(problem.q)) if warmth is None else values[0] * warmth
        name = f"growth of one metre of {self.where.joint}" if self.of_scale else "growth of one metre"
        if "time" in self.uses and problem.time is not None:
            return Drawn((problem.time - self.start) / 60, "time", "min", growth, name, "m")
        warm = np.zeros(len(growth)) if problem.warmth is None else problem.warmth
        return Drawn(warm + REFERENCE_TEMPERATURE, "temperature", "°C", growth, name, "m")

    def sentence(self, values: Array) -> str:
        if self.variant.startswith("warmup"):
            return (
                f"The arm grows by {short(values[0] * 1e6)} µm per metre while it warms up, "
                f"with a time constant of {self.constant / 60:.0f} min (inferred from time alone)."
            )
        if self.of_scale:
            of = f"rack or scale of {self.where.joint}"
            return f"The {of} grows by {values[0] * 1e6:.1f} µm per metre and kelvin."
        return f"The links grow by {values[0] * 1e6:.1f} µm per metre and kelvin."
