"""The gravity compensator pulls more or less than the model's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import REFERENCE_TEMPERATURE, Problem
from ..robot.extended_robot.cylinder import ATMOSPHERE
from ..robot.kinematics import Arm, Array, Frames
from ..robot.loads import Loads
from ..robot.rotations import cross
from .base import Depends, Param, Rest, short
from .drawn import Drawn
from .kinds import LoadEffect
from .place import Where

REFERENCE_KELVIN = 273.15 + REFERENCE_TEMPERATURE


@dataclass(frozen=True)
class GravityCompensator(LoadEffect):
    """The force F between the pivots changes, by `variant`:

    charge       ΔF = r A p (l/(l − Δs))^n of the gas, or r k (s − s₀) of the spring (its rate)
    preload      ΔF = constant [N]: a spring's length, or friction that always stands on one side
    exponent     n + Δn in place of n: a gas that was taken for isothermal (1), or for adiabatic (1.4)
    temperature  ΔF = c (T − 20 °C) A p (l/(l − Δs))^n: a sealed gas has c = 1/293 per K

    Klimchik et al. 2017, eqs. (2)–(6), in physical form (absolute pressure).
    """

    kind: str = "gas"

    cause: ClassVar[str] = "gravity_compensator"
    title: ClassVar[str] = "Gravity compensator differs from the model"
    in_drake: ClassVar[str] = (
        "a LinearSpringDamper between its pivots (coil), or a pair of forces at the plant's port (gas)"
    )
    together: ClassVar[bool] = True
    wholes: ClassVar[dict[str, str]] = {
        "precharge_bar": "bar",
        "gauge_bar": "bar",
        "rate": "N/m",
        "free_length": "m",
    }
    reading: ClassVar[str] = "{gauge}"
    depends: ClassVar[Depends] = frozenset({"joints", "temperature"})
    equation: ClassVar[str] = "Delta tau = -Delta F(s) thin (dif s) / (dif q_2)"
    separate: ClassVar[dict[str, str]] = {
        "gear_eccentricity": "record the motor torque of joint 2 (3 % is enough)",
        "gear_ratio": "record the motor torque of joint 2 (3 % is enough)",
        "joint_compliance": "record the motor torque of joint 2, or add a load",
        "link_bending": "record the motor torque of joint 2, or a target on the link near its joint",
        "link_mass": "{gauge}, or weigh the link",
        "lost_motion": "a load that reverses the torque of joint 2",
        "thermal_growth": "{gauge}, cold and warm",
    }

    @classmethod
    def words(cls, where: Where, problem: Problem | None) -> Mapping[str, str]:
        law = None if problem is None else problem.compensator
        coil = law is not None and law.data.kind == "spring"
        gauge = "measure the rate and the free length of its spring" if coil else "read the pressure gauge"
        return {**super().words(where, problem), "gauge": gauge}

    @property
    def params(self) -> tuple[Param, ...]:
        if self.variant == "preload":
            return (Param("preload", "N", 1e3, "constant force, over the model's"),)
        if self.variant == "exponent":
            what = "polytropic exponent of the gas, over the model's"
            return (Param("exponent", "1", 0.1, what, lower=-0.4, upper=0.4),)
        if self.variant == "temperature":
            return (Param("coefficient", "1/K", 3e-3, "relative change of the pressure per K over 20 °C"),)
        what = "gas charge (absolute pressure)" if self.kind == "gas" else "spring rate"
        return (Param("relative", "1", 0.1, f"{what} over the model's, minus one", lower=-1.0),)

    @property
    def uses(self) -> Depends:
        return self.depends if self.variant == "temperature" else frozenset({"joints"})

    @property
    def part(self) -> str:
        return "gas" if self.variant in ("charge", "exponent") else self.variant

    @property
    def bounded(self) -> bool:
        return self.variant == "exponent"  # 1 to 1.4, whatever the model says

    @property
    def rare(self) -> bool:
        return self.variant == "exponent"

    @property
    def whole(self) -> bool:
        return self.variant != "exponent"  # whose gas was described wrongly knows no better how much there is

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        if problem.compensator is None:
            return "the robot's TOML has no [compensator]: describe it there if the robot has one"
        return None

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[GravityCompensator]:
        warm_and_cold = problem.warmth is not None and np.ptp(problem.warmth) > 0
        return [place for place in cls.places(problem) if warm_and_cold or place.variant != "temperature"]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[GravityCompensator]:
        if problem.compensator is None:
            return []
        kind = problem.compensator.data.kind
        gas = ("exponent", "temperature") if kind == "gas" else ()
        return [cls(variant=variant, kind=kind) for variant in ("charge", "preload", *gas)]

    def of_whole(self, problem: Problem, name: str, value: float, warmth: float) -> float | None:
        if problem.compensator is None:
            return None
        data = problem.compensator.data
        if name == "free_length" and self.variant == "preload" and data.rate and data.free_length is not None:
            return data.rate * (data.free_length - value)
        if name == "free_length" or self.variant != "charge":
            return None
        if name == "rate":
            return value / data.rate - 1 if data.rate else None
        if not data.precharge:
            return None
        pressure = 1e5 * value + (ATMOSPHERE if name == "gauge_bar" else 0.0)
        return pressure * REFERENCE_KELVIN / (REFERENCE_KELVIN + warmth) / data.precharge - 1

    def _scale(self, problem: Problem) -> Array:
        """(N,) relative change of the charge per unit of the parameter."""
        if self.variant != "temperature":
            return np.ones(len(problem.q))
        return np.zeros(len(problem.q)) if problem.warmth is None else problem.warmth

    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        law = loads.compensator
        assert law is not None
        if self.variant == "preload":
            law = replace(law, preload=law.preload + float(values[0]))
        elif self.variant == "exponent":
            law = law.of_exponent(law.data.exponent + float(values[0]))
        else:
            law = replace(law, charge=law.charge + values[0] * self._scale(problem))
        return arm, replace(loads, compensator=law)

    def wrench(self, problem: Problem, where: Frames, loads: Loads) -> Array:
        law = loads.compensator
        assert law is not None
        end, direction, s = law.ends(where)
        if self.variant == "preload":
            change = np.ones_like(s)
        elif self.variant == "exponent":
            change = law.by_exponent(s)
        else:
            change = law.force(s)[2] * self._scale(problem)
        pull = (change[:, None] * direction)[:, None]
        torque = cross(end[:, None] - where.origin, pull)
        out = np.zeros((*where.origin.shape[:2], 6, 1))
        between = slice(law.body + 1, law.arm + 1)
        axes = where.axes[:, between]
        out[:, between, :3, 0] = np.einsum(
            "nsci,nsi->nsc", axes[:, :, :3], np.broadcast_to(pull, torque.shape)[:, between]
        )
        out[:, between, 3:, 0] = np.einsum("nsci,nsi->nsc", axes[:, :, 3:], torque[:, between])
        return out

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        j, torque = self.joint_torque(problem, rest, values)
        return self.drawn_over_joint(problem, j, torque)

    def sentence(self, values: Array) -> str:
        if self.variant == "preload":
            word = "more" if values[0] > 0 else "less"
            return f"The gravity compensator pulls {short(abs(values[0]))} N {word} than the model says."
        if self.variant == "exponent":
            word = "above" if values[0] > 0 else "below"
            return f"The exponent of the compensator's gas is {abs(values[0]):.2f} {word} the model's."
        if self.variant == "temperature":
            return (
                f"The compensator's pressure changes by {100 * values[0]:.2f} % per K (sealed gas: 0.34 %)."
            )
        what = "gas charge" if self.kind == "gas" else "spring rate"
        word = "higher" if values[0] > 0 else "lower"
        return f"The compensator's {what} is {100 * abs(values[0]):.1f} % {word} than the model's."
