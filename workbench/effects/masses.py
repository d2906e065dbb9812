"""A mass or centre of mass that differs from what is stated: base of payload and link mass.

The last link and the tool move together: what the data show of them is their mass and first moment together,
and only where that sits, and what is usual of each, speaks for one of the two.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array, Frames
from ..robot.rotations import cross
from .base import Effect, Param
from .kinds import LoadEffect
from .place import Parameter

OF_ARM = 0.1  # of the mass of the moving links: what is usually mounted, half of what such an arm may carry


@dataclass(frozen=True)
class MassEffect(LoadEffect):
    """Mass (`variant` "mass") or centre of mass ("com") of a body differs from its `mass` [kg] and place.

    A centre of mass is fitted as first moment [kg·m], which is linear, and reported as a shift. usual: mass
    [kg] of which what is off is a usual share; most: [kg] by which none is off. reference: whose numbers they
    differ from, in words.
    """

    mass: float = 0.0
    usual: float = 0.0
    most: float = np.inf

    reference: ClassVar[str]
    equation: ClassVar[str] = "Delta tau = J^T (m + Delta m) g (c + Delta c) - J^T m g (c)"
    in_drake: ClassVar[str] = "mass and centre of mass of the body, in the Context"
    wholes: ClassVar[dict[str, str]] = {"mass_kg": "kg"}
    together: ClassVar[bool] = True

    def _mass(self, meaning: str, usual: float) -> tuple[Param, ...]:
        return (Param("mass", "kg", 0.05 * usual, meaning, lower=-self.mass, upper=self.most),)

    def _moments(self, usual: float, most: float) -> tuple[Param, ...]:
        return tuple(Param(f"moment_{axis}", "kg·m", usual, lower=-most, upper=most) for axis in "xyz")

    @property
    def bounded(self) -> bool:
        return self.variant == "mass"

    @property
    def names(self) -> tuple[str, ...]:
        if self.variant == "mass":
            return ("mass",)
        return tuple(f"{kind}_{axis}" for kind in ("com", "moment") for axis in "xyz")

    def given(self, numbers: Mapping[str, float]) -> Array:
        if self.variant == "mass":
            return super().given(numbers)
        return np.array([numbers.get(f"moment_{a}", self.mass * numbers.get(f"com_{a}", 0.0)) for a in "xyz"])

    def of_whole(self, problem: Problem, name: str, value: float, warmth: float) -> float | None:
        return value - self.mass if self.variant == "mass" else None

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        std = np.sqrt(np.diag(covariance))
        if self.variant == "mass":
            return (Parameter("mass", float(values[0]), float(std[0]), "kg", f"over {self.reference} mass"),)
        if not self.mass:
            return super().report(values, covariance)
        return tuple(
            Parameter(
                f"com_{axis}", float(v / self.mass), float(s / self.mass), "m", f"over {self.reference} place"
            )
            for axis, v, s in zip("xyz", values, std, strict=True)
        )

    def beside(self, others: Iterable[tuple[Effect, Array]]) -> Effect:
        """A centre of mass moves by the first moment over the mass that is there with what was found."""
        more = sum(
            float(values[0])
            for other, values in others
            if other.key == self.key and isinstance(other, MassEffect) and other.variant == "mass"
        )
        return replace(self, mass=max(self.mass + more, 0.0)) if self.variant == "com" else self

    def reported_size(self, size: float) -> tuple[float, str]:
        return (size / self.mass, "m") if self.variant == "com" and self.mass else (size, self.params[0].unit)


def usually_mounted(problem: Problem) -> float:
    """Mass [kg] of what a robot like this carries all the time, stated or not."""
    return max(problem.campaign.tool_mass, OF_ARM * float(problem.arm.mass[1:].sum()))


def mass_wrench(problem: Problem, where: Frames, slot: int, mass: Array, moment: Array) -> Array:
    """Local wrenches (N, S, 6) of a mass (N,) with first moment (N, 3) carried behind `slot`."""
    arm, borne = problem.arm, slice(slot + 1)  # by the slots before it
    at = mass[:, None] * where.p[slot] + np.einsum("nij,nj->ni", where.R[slot], moment)
    first = at[:, None] - mass[:, None, None] * where.origin[:, borne]
    force, torque = mass[:, None] * arm.gravity, cross(first, arm.gravity)
    out = np.zeros((len(mass), arm.slots, 6))
    out[:, borne, :3] = np.einsum("nsci,ni->nsc", where.axes[:, borne, :3], force)
    out[:, borne, 3:] = np.einsum("nsci,nsi->nsc", where.axes[:, borne, 3:], torque)
    return out
