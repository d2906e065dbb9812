"""Mass or centre of mass of a link differs from the URDF's."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array, Frames
from ..robot.loads import Loads
from .base import Param, short
from .masses import MassEffect, mass_wrench, usually_mounted
from .place import ALL, Parameter, Where

ALL_USUAL, ALL_MOST = 0.5, 4.0  # of their masses, by which published URDFs are off


@dataclass(frozen=True)
class LinkMass(MassEffect):
    """Gravity of the link acts with m + Δm at c (`variant` "mass"), or with m at c + Δc ("com"); of the whole
    arm, with m (1 + r) of every link alike ("all").

    The fitted centre-of-mass parameters are first moments m Δc [kg·m] on the URDF link's axes, so that
    both are linear. Where no load was stated, the last link's usual error is that of what may be mounted
    on it. All masses together are off by much in many a published URDF, which has them from solid bodies of
    the CAD model, or from another robot: by half is usual, by a factor of five no rarity.
    """

    cause: ClassVar[str] = "link_mass"
    title: ClassVar[str] = "Mass of a link, or of all links alike, differs from the model"
    reference: ClassVar[str] = "the URDF's"
    reading: ClassVar[str] = "weigh the link"
    separate: ClassVar[dict[str, str]] = {
        "joint_compliance": "measure with two payloads: a stiffness acts on both, a link mass on neither",
        "payload": "weigh what the flange carries, or measure without it",
        "gravity_compensator": "{gauge}, or weigh the link",
        "gear_eccentricity": "record the motor torque of the joint, or weigh the link",
        "link_mass": "record the motor torques of the joints",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        if self.variant == "mass":
            return self._mass("added to the URDF's mass", self.usual)
        most = 0.3 * self.usual  # a centre of mass does not leave its link
        return self._moments(0.02 * self.usual, most)

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        return None if cls.sites(problem) else "the URDF gives no link a mass: state the masses there"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[LinkMass]:
        """Moving links that have a mass, and all of them together."""
        arm = problem.arm
        usual = arm.mass.copy()
        if not problem.loads.mass.all():
            usual[arm.n] = max(arm.mass[arm.n], usually_mounted(problem))
        have = [k for k in range(1, arm.n + 1) if arm.mass[k] > 0]
        each = [
            LinkMass(
                Where(link=arm.links[k]), variant, float(arm.mass[k]), float(usual[k]), float(arm.mass.sum())
            )
            for k in have
            for variant in ("mass", "com")
        ]
        total = float(arm.mass[1:].sum())
        return [*each, ArmMass(Where(), ALL, total, total, ALL_MOST * total)] if len(have) > 1 else each

    def _changes(self, arm: Arm) -> Iterator[tuple[int, Array, Array]]:
        """Slots, each with mass (p,) and first moment (3, p) on the arm's axes, per unit."""
        k = arm.slot_of_link(str(self.where.link))
        if self.variant == "mass":
            yield k, np.ones(1), (arm.moment[k] / arm.mass[k])[:, None]
        else:
            yield k, np.zeros(3), arm.R_link[k]

    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        mass, moment = arm.mass.copy(), arm.moment.copy()
        for k, by_mass, by_moment in self._changes(problem.arm):
            mass[k] += by_mass @ values
            moment[k] += by_moment @ values
        return replace(arm, mass=mass, moment=moment), loads

    def wrench(self, problem: Problem, where: Frames, loads: Loads) -> Array:
        n_poses, parts = len(problem.q), []
        for k, mass, moment in self._changes(problem.arm):
            columns = [
                mass_wrench(problem, where, k, np.full(n_poses, m), np.broadcast_to(first, (n_poses, 3)))
                for m, first in zip(mass, moment.T, strict=True)
            ]
            parts.append(np.stack(columns, axis=-1))
        return np.asarray(sum(parts))

    def sentence(self, values: Array) -> str:
        if self.variant == "mass":
            word = "heavier" if values[0] > 0 else "lighter"
            return f"{self.where.link} is {abs(values[0]):.1f} kg {word} than its URDF says."
        if not self.mass:
            return f"The first moment of {self.where.link} is off by {np.linalg.norm(values):.3g} kg·m."
        shift = float(np.linalg.norm(values)) / self.mass * 1e3
        return f"The centre of mass of {self.where.link} is {short(shift)} mm off its place in the URDF."


class ArmMass(LinkMass):
    """The form of the whole arm: gravity of every link acts with m (1 + r) at c, r the same of all."""

    called: ClassVar[str] = "mass of all links alike"

    @property
    def names(self) -> tuple[str, ...]:
        return ("relative",)

    @property
    def params(self) -> tuple[Param, ...]:
        meaning = "masses of all links over the URDF's, minus one"
        return (Param("relative", "1", ALL_USUAL, meaning, lower=-1.0, upper=ALL_MOST),)

    def given(self, numbers: Mapping[str, float]) -> Array:
        return np.array([numbers.get("relative", 0.0)])

    def of_whole(self, problem: Problem, name: str, value: float, warmth: float) -> float | None:
        return value / self.mass - 1

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        (param,) = self.params
        std = float(covariance[0, 0]) ** 0.5
        return (Parameter("relative", float(values[0]), std, "1", param.meaning),)

    def _changes(self, arm: Arm) -> Iterator[tuple[int, Array, Array]]:
        for k in range(1, arm.n + 1):
            yield k, arm.mass[k, None], arm.moment[k][:, None]

    def sentence(self, values: Array) -> str:
        return f"All links weigh {1 + values[0]:.2f} times what the URDF says."
