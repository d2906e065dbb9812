"""Mass or centre of mass of a payload differs from what was stated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array, Frames
from ..robot.loads import Loads
from .base import Param
from .masses import MassEffect, mass_wrench
from .place import Where


@dataclass(frozen=True)
class Payload(MassEffect):
    """Gravity of the payload acts with m + Δm at c (`variant` "mass"), or with m at c + Δc ("com").

    The fitted centre-of-mass parameters are first moments m Δc, so that both are linear.
    """

    com: tuple[float, float, float] = (0.0, 0.0, 0.0)

    cause: ClassVar[str] = "payload"
    title: ClassVar[str] = "Payload differs from what was stated"
    reference: ClassVar[str] = "the stated"
    equation: ClassVar[str] = "Delta tau = J^T (m + Delta m) g (c + Delta c) - J^T m g (c)"
    reading: ClassVar[str] = "weigh the payload"
    separate: ClassVar[dict[str, str]] = {
        "joint_compliance": "weigh the payload, or measure a third load",
        "link_mass": "weigh the payload",
        "lost_motion": "weigh the payload, or measure a third load",
        "link_bending": "weigh the payload",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        if self.variant == "mass":
            return (
                Param("mass", "kg", 0.05 * max(self.mass, 1.0), "added to the stated mass", lower=-self.mass),
            )
        size = max(self.mass, 1.0)
        return tuple(
            Param(f"moment_{axis}", "kg·m", 0.03 * size, lower=-0.5 * size, upper=0.5 * size)
            for axis in "xyz"
        )

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        if (problem.campaign.poses.payload > 0).any():
            return None
        return "no pose with a payload: name one in the column payload, and state it under [payloads]"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Payload]:
        c = problem.campaign
        return [
            cls(Where(payload=name), variant, float(c.load_mass[i]), tuple(float(x) for x in c.load_com[i]))  # type: ignore[arg-type]
            for i, name in enumerate(c.payload_names)
            if i > 0 and (c.poses.payload == i).any() and c.load_mass[i] > 0
            for variant in ("mass", "com")
        ]

    def _change(self, problem: Problem) -> tuple[Array, Array]:
        """(N, p) mass and (N, 3, p) first moment per unit of each parameter."""
        c = problem.campaign
        here = (c.poses.payload == c.payload_names.index(str(self.where.payload))).astype(float)
        if self.variant == "mass":
            return here[:, None], here[:, None, None] * np.array(self.com)[:, None]
        return np.zeros((len(here), 3)), here[:, None, None] * np.eye(3)

    def apply(self, problem: Problem, arm: Arm, loads: Loads, values: Array) -> tuple[Arm, Loads]:
        mass, moment = self._change(problem)
        return arm, replace(loads, mass=loads.mass + mass @ values, moment=loads.moment + moment @ values)

    def wrench(self, problem: Problem, where: Frames, loads: Loads) -> Array:
        mass, moment = self._change(problem)
        flange = problem.arm.slots - 1
        return np.stack(
            [mass_wrench(problem, where, flange, mass[:, i], moment[:, :, i]) for i in range(mass.shape[1])],
            axis=-1,
        )

    def sentence(self, values: Array) -> str:
        if self.variant == "mass":
            word = "heavier" if values[0] > 0 else "lighter"
            return f"Payload '{self.where.payload}' is {abs(values[0]):.2f} kg {word} than stated."
        shift = np.linalg.norm(values) / self.mass * 1e3
        return f"The centre of mass of payload '{self.where.payload}' is off by {shift:.0f} mm."
