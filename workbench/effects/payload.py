"""Mass or centre of mass of a payload, or of the tool, differs from what was stated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Arm, Array, Frames
from ..robot.loads import Loads
from .base import Param, short
from .masses import MassEffect, mass_wrench, usually_mounted
from .place import Where


@dataclass(frozen=True)
class Payload(MassEffect):
    """Gravity of the payload acts with m + Δm at c (`variant` "mass"), or with m at c + Δc ("com").

    The fitted centre-of-mass parameters are first moments m Δc, so that both are linear. The tool, which is
    always mounted, is a payload as well, whether it was stated or not.
    """

    com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    always_there: bool = False

    cause: ClassVar[str] = "payload"
    title: ClassVar[str] = "Payload or tool differs from what was stated"
    reference: ClassVar[str] = "the stated"
    reading: ClassVar[str] = "weigh what the flange carries"
    separate: ClassVar[dict[str, str]] = {
        "joint_compliance": "weigh what the flange carries, or measure a third load",
        "link_mass": "weigh what the flange carries",
        "lost_motion": "weigh what the flange carries, or measure a third load",
        "link_bending": "weigh what the flange carries",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        size = max(self.usual, 1.0)
        if self.variant == "mass":
            return self._mass("added to the stated mass", size)
        return self._moments(0.03 * size, 0.5 * size)

    @property
    def whole(self) -> bool:
        return self.variant == "mass" or self.mass > 0  # what is not there has no centre of mass

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        if cls.places(problem):
            return None
        return "no payload or tool stated, and no masses in the URDF: state one of them"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Payload]:
        """Where the model has no masses, what is always there is told from none of those that it lacks."""
        weighed = problem.arm.weighed
        return [one for one in cls.places(problem) if weighed or one._carried(problem).min() == 0]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[Payload]:
        """The payloads that are carried, and the tool: one that nobody stated where the model has masses,
        unless a payload is in all poses, and so moves with it."""
        c = problem.campaign
        carried = [i for i in range(1, len(c.payload_names)) if (c.poses.payload == i).any()]
        loads = [
            (c.payload_names[i], float(c.load_mass[i]), float(c.load_mass[i]), np.inf, c.load_com[i], False)
            for i in carried
            if c.load_mass[i] > 0
        ]
        one_always = len(carried) == 1 and c.poses.payload.all() and c.load_mass[carried[0]] > 0
        if c.tool_mass > 0 or (problem.arm.weighed and not one_always):
            most = max(float(problem.arm.mass.sum()), c.tool_mass) if problem.arm.weighed else np.inf
            loads.append((c.tool_name, c.tool_mass, usually_mounted(problem), most, c.tool_com, True))
        return [
            cls(Where(payload=name), variant, mass, usual, most, (float(x), float(y), float(z)), always)
            for name, mass, usual, most, (x, y, z), always in loads
            for variant in ("mass", "com")
        ]

    def _carried(self, problem: Problem) -> Array:
        """(N,) 1 in poses that carry it, else 0."""
        c = problem.campaign
        if self.always_there:
            return np.ones(len(problem.q))
        return np.asarray(c.poses.payload == c.payload_names.index(str(self.where.payload)), dtype=float)

    def _change(self, problem: Problem) -> tuple[Array, Array]:
        """(N, p) mass and (N, 3, p) first moment per unit of each parameter."""
        here = self._carried(problem)
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
        if self.always_there and self.variant == "mass" and not self.mass:
            return (
                f"{values[0]:.2f} kg that nobody stated are mounted at the flange, or are of the last link."
            )
        what = f"payload '{self.where.payload}'"
        if self.always_there:
            what = "the tool (or the last link with it)"
        if self.variant == "mass":
            word = "heavier" if values[0] > 0 else "lighter"
            return f"{what[0].upper()}{what[1:]} is {abs(values[0]):.2f} kg {word} than stated."
        if not self.mass:
            return f"The first moment of {what} is off by {np.linalg.norm(values):.3g} kg·m."
        shift = float(np.linalg.norm(values)) / self.mass * 1e3
        place = "its stated place" if any(self.com) else "the flange's origin"
        return f"The centre of mass of {what} is {short(shift)} mm off {place}."
