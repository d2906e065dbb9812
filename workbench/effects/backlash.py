"""Backlash: the joint rests where it was last pushed from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Depends, Effect, Param, motion_said
from .kinds import TransmissionEffect
from .place import Where
from .unnamed.joints import Side


@dataclass(frozen=True)
class Backlash(TransmissionEffect):
    """Δq = −h · dir, dir = sign of the joint's last motion (0: not known, no shift).

    The joint lags behind its motor: it stops short of the command on the side that it comes from. h is
    half of the reversal error, in rad (m for a sliding joint): half the play, and the wind-up τ_c/K of
    the joint under its own friction.
    """

    sliding: bool = False

    cause: ClassVar[str] = "backlash"
    title: ClassVar[str] = "Backlash and friction wind-up"
    depends: ClassVar[Depends] = frozenset({"side"})
    equation: ClassVar[str] = 'Delta q = -h thin sgn(dot(q)_"last")'
    separate: ClassVar[dict[str, str]] = {
        "lost_motion": "a pose from both sides under the same load: lost motion does not see the side",
        "gear_kinematic_error": "repeat poses from the other side of approach",
        "backlash": "reverse one joint at a time",
        "drift": "change the side of approach in random order",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        meaning = "the joint stops short of the command by this much"
        return (Param("half_width", "m" if self.sliding else "rad", 3e-5, meaning, lower=0.0),)

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """A real play is not the same all around the gear."""
        return self._shares(problem, 0.2)

    def rarer(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """Some gears are worn where they mostly work."""
        return self._shares(problem, 0.6)

    def _shares(self, problem: Problem, share: float) -> list[tuple[float, Effect]]:
        sides = (one for one in Side.sites(problem) if one.where == self.where)
        return [(share * self.params[0].typical / one.params[0].typical, one) for one in sides]

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        n = problem.arm.n
        if problem.campaign.poses.side is None:
            return f"no column dir1..dir{n}: record the side of approach"
        if not cls.sites(problem):
            return f"dir1..dir{n} never change sign: approach poses from both sides"
        return None

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Backlash]:
        """Joints that were approached from both sides."""
        direction = problem.campaign.poses.side
        if direction is None:
            return []
        both = np.ptp(np.sign(direction), axis=0) == 2
        return [place for place, seen in zip(cls.places(problem), both, strict=True) if seen]

    @classmethod
    def places(cls, problem: Problem) -> Sequence[Backlash]:
        return [cls(Where(joint=j.name), sliding=j.kind == "prismatic") for j in problem.robot.joints]

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        if direction is None:
            return 0.0 * q[:, :1]
        j = joints.index(str(self.where.joint))
        return -direction[:, j : j + 1]

    def sentence(self, values: Array) -> str:
        size = motion_said(abs(values[0]), self.sliding)
        if values[0] < 0:
            return (
                f"{self.where.joint} goes {size} past the command, away from the side that it comes from; or "
                "dir says where it came from, and not which way it moved."
            )
        return f"{self.where.joint} stops {size} short on the side that it comes from."
