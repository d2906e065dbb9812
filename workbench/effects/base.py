"""What an effect is: a small motion of frames, a yield under load, a change of load, or of what is seen.

An effect is one file with one class. It derives from one of the four kinds below, says where it can
sit (`sites`), what data it needs (`needs`), and its equation. Prediction and Jacobian for all
effects are made from that by `model.py`; Drake's side by `simulate.py` (statics) and by the closed
loop.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array, Frames
from ..robot.loads import Loads
from .place import NOWHERE, Parameter, Where


@dataclass(frozen=True)
class Param:
    """A parameter that is fitted. `typical` is its usual size, `lower`, `upper` what physics allows."""

    name: str
    unit: str
    typical: float
    meaning: str = ""
    lower: float = -np.inf
    upper: float = np.inf


@dataclass(frozen=True)
class Effect(ABC):
    """One cause at one place.

    cause: id of the contract. title: for people. equation: typst mathematics. separate: rival cause →
    the measurement that tells it apart (in words). variant: forms of the same cause share cause and
    place and differ in this; they are never each other's rivals. settings: names of the fields that
    are numbers but not fitted (a time constant, say); they are kept with the values in model.toml.
    ordered: `where` needs an order. together: the variants are parts of one law that may be off at once.
    """

    where: Where = NOWHERE
    variant: str = ""

    cause: ClassVar[str]
    title: ClassVar[str]
    equation: ClassVar[str] = ""
    separate: ClassVar[Mapping[str, str]] = {}
    settings: ClassVar[tuple[str, ...]] = ()
    ordered: ClassVar[bool] = False
    together: ClassVar[bool] = False

    @property
    @abstractmethod
    def params(self) -> tuple[Param, ...]:
        """The fitted parameters, in the order of `values`."""

    def finer(self) -> Sequence[Effect]:
        """The same effect with other settings, to choose from once it is accepted."""
        return ()

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        """Why this campaign cannot show the cause at all; None when it can."""
        return None

    @classmethod
    @abstractmethod
    def sites(cls, problem: Problem) -> Sequence[Effect]:
        """Every place (and variant) that may be tested on this problem."""

    @classmethod
    def places(cls, problem: Problem) -> Sequence[Effect]:
        """Every place where it can sit, whether this campaign would show it or not."""
        return cls.sites(problem)

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        """The parameters as the contract names them, from the fitted ones (p,), (p, p)."""
        std = np.sqrt(np.diag(covariance))
        return tuple(
            Parameter(p.name, float(v), float(s), p.unit, p.meaning)
            for p, v, s in zip(self.params, values, std, strict=True)
        )

    @property
    def names(self) -> tuple[str, ...]:
        """The names that `given` understands."""
        return tuple(p.name for p in self.params)

    def given(self, numbers: Mapping[str, float]) -> Array:
        """The fitted parameters (p,) from numbers by name: `report` the other way round."""
        return np.array([numbers.get(p.name, 0.0) for p in self.params])

    def sentence(self, values: Array) -> str:
        """What was found, for a busy engineer."""
        return ""

    @property
    def key(self) -> tuple[str, Where]:
        """Cause and place, without form: what the verdict is about."""
        return self.cause, replace(self.where, order=None)

    @property
    def label(self) -> str:
        where = str(self.where)
        return f"{self.cause}({where})" if where else self.cause


class DirectEffect(Effect):
    """A motion of frames that does not depend on load and is linear in its parameters."""

    @abstractmethod
    def motion(self, problem: Problem) -> Mapping[int, Array]:
        """Column 6 · slot + component → (N, p) motion [m, rad] per unit of each parameter."""


class TransmissionEffect(DirectEffect):
    """Commanded joint → joint angle without load, of the joint `where.joint`."""

    @abstractmethod
    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        """(N, p) joint motion [rad, m] per unit of each parameter, for joints q: (N, n)."""

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        column = int(problem.arm.axial[problem.joint(self.where.joint)])
        return {column: self.basis(problem.q, problem.campaign.direction, problem.arm.names)}


class YieldEffect(Effect):
    """A slot that yields under its own wrench."""

    @abstractmethod
    def slot(self, arm: Arm) -> int:
        """Number of the slot that yields."""

    @abstractmethod
    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        """Motion (N, 6), its derivative by the wrench (N, 6, 6) and by the parameters (N, 6, p).

        wrench: (N, 6) [N, N·m] at the slot, on its own axes.
        """


class LinearYield(YieldEffect):
    """A yield with one parameter: motion = value · C · wrench."""

    @abstractmethod
    def compliance(self, arm: Arm) -> Array:
        """(6, 6) compliance of the slot per unit of the parameter."""

    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        C = self.compliance(arm)
        unit = wrench @ C.T
        by_wrench = np.broadcast_to(values[0] * C, (len(wrench), 6, 6))
        return values[0] * unit, by_wrench, unit[:, :, None]


class LoadEffect(Effect):
    """A change of what pulls on the arm."""

    @abstractmethod
    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        """Arm and loads with the effect in them."""

    @abstractmethod
    def wrench(self, problem: Problem, where: Frames, loads: Loads) -> Array:
        """(N, S, 6, p) change of the local wrenches per unit of each parameter."""


@dataclass(frozen=True)
class MassEffect(LoadEffect):
    """Mass (`variant` "mass") or centre of mass ("com") of a body differs from its `mass` [kg] and place.

    A centre of mass is fitted as first moment [kg·m], which is linear, and reported as a shift. reference:
    whose numbers they differ from, in words.
    """

    mass: float = 0.0

    reference: ClassVar[str]

    @property
    def names(self) -> tuple[str, ...]:
        if self.variant == "mass":
            return ("mass",)
        return tuple(f"{kind}_{axis}" for kind in ("com", "moment") for axis in "xyz")

    def given(self, numbers: Mapping[str, float]) -> Array:
        if self.variant == "mass":
            return super().given(numbers)
        return np.array([numbers.get(f"moment_{a}", self.mass * numbers.get(f"com_{a}", 0.0)) for a in "xyz"])

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        std = np.sqrt(np.diag(covariance))
        if self.variant == "mass":
            return (Parameter("mass", float(values[0]), float(std[0]), "kg", f"over {self.reference} mass"),)
        return tuple(
            Parameter(
                f"com_{axis}", float(v / self.mass), float(s / self.mass), "m", f"over {self.reference} place"
            )
            for axis, v, s in zip("xyz", values, std, strict=True)
        )


class InstrumentEffect(Effect):
    """How the points are seen; linear in its parameters."""

    @abstractmethod
    def seen(self, problem: Problem, points: Array) -> Array:
        """(N, T, 3, p) change of the points (N, T, 3) [m] in the instrument's frame."""


def mass_wrench(problem: Problem, where: Frames, slot: int, mass: Array, moment: Array) -> Array:
    """Local wrenches (N, S, 6) of a mass (N,) with first moment (N, 3) carried behind `slot`."""
    arm = problem.arm
    at = mass[:, None] * where.p[slot] + np.einsum("nij,nj->ni", where.R[slot], moment)
    first = at[:, None] - mass[:, None, None] * where.origin
    force = np.broadcast_to((mass[:, None] * arm.gravity)[:, None], first.shape)
    torque = np.cross(first, arm.gravity)
    out = np.zeros((len(mass), arm.slots, 6))
    out[..., :3] = np.einsum("nsci,nsi->nsc", where.axes[:, :, :3], force)
    out[..., 3:] = np.einsum("nsci,nsi->nsc", where.axes[:, :, 3:], torque)
    out[:, slot + 1 :] = 0.0
    return out


SIN_COS = ("amplitude", "phase", "sin", "cos")


def sin_cos(numbers: Mapping[str, float]) -> Array:
    """(a, b) of  a sin x + b cos x  from numbers by name: sin and cos, or amplitude and phase."""
    amplitude, phase = numbers.get("amplitude", 0.0), numbers.get("phase", 0.0)
    a, b = amplitude * np.cos(phase), amplitude * np.sin(phase)
    return np.array([numbers.get("sin", a), numbers.get("cos", b)])


def amplitude_phase(values: Array, covariance: Array) -> tuple[tuple[float, float], tuple[float, float]]:
    """(amplitude, std) and (phase, std) of  a sin x + b cos x = A sin(x + φ), from (a, b)."""
    a, b = values
    amplitude = float(np.hypot(a, b))
    if amplitude == 0:
        return (0.0, float(np.sqrt(covariance.trace() / 2))), (0.0, np.pi)
    along = np.array([a, b]) / amplitude
    across = np.array([-b, a]) / amplitude**2
    std = float(np.sqrt(along @ covariance @ along)), float(np.sqrt(across @ covariance @ across))
    return (amplitude, std[0]), (float(np.arctan2(b, a)), std[1])
