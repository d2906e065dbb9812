"""A base that tips to one side and not to the other, as on a foot that lifts: short, or without its shim."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import RX, TX, TZ, Array
from .loads import LEAST, Uneven

WAYS = 16  # directions of the axis about which it tips
LIFTS = (-0.3, 0.0, 0.3)  # moments at which a foot lifts, or is on the ground again, over the largest
AS = "as on a foot that lifts"
LEVER = 0.3  # m: how far the feet are from the base's origin


@dataclass(frozen=True)
class Foot(Uneven):
    """The base turns about one axis on the floor, `axis` [rad] from the base's x, where the moment about it
    is larger than what lifts a foot, and evenly from there on: not in proportion to the moment, as where the
    ground yields. That axis goes past the base's origin, which so rises and shifts by other amounts of the
    same moment."""

    variant: str = "foot"
    axis: float = 0.0

    settings: ClassVar[tuple[str, ...]] = (*Uneven.settings, "axis")
    like: ClassVar[str] = f"a base that tips, {AS}"

    @property
    def functions(self) -> int:
        return 3 * len(LIFTS)

    @property
    def variable(self) -> str:
        side = round(np.degrees(self.axis))
        about = f"about the axis at {side}° to its x, {AS}"
        return f"overturning moment (the base tips {about})"

    def moment(self, problem: Problem) -> Array:
        """(N, 1) [N·m] overturning moment about the axis."""
        x, y = problem.nominal_load.local[:, 0, RX : RX + 2].T
        return np.asarray(np.cos(self.axis) * x + np.sin(self.axis) * y)[:, None]

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        beyond = np.maximum(self.moment(problem) / self.largest - LIFTS, 0.0)
        none = np.zeros_like(beyond)
        turn, rise, shift = (np.hstack([beyond if k == i else none for k in range(3)]) for i in range(3))
        c, s = np.cos(self.axis), np.sin(self.axis)
        rise, shift = LEVER * rise, LEVER * shift
        return {RX: c * turn, RX + 1: s * turn, TX: -s * shift, TX + 1: c * shift, TZ: rise}

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Foot]:
        """About each of some axes about which there is a moment."""
        angles = np.arange(WAYS) * 360 / WAYS
        every = [cls(variant=f"{cls.variant} {way:g}", axis=np.radians(way)) for way in angles.tolist()]
        most = [float(one.x(problem).max(initial=0.0)) for one in every]
        return [replace(one, largest=m) for one, m in zip(every, most, strict=True) if m > LEAST]
