"""Scale of the instrument."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.calibrated import contradicted
from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Param, Rest
from .drawn import Drawn
from .kinds import InstrumentEffect


@dataclass(frozen=True)
class TrackerScale(InstrumentEffect):
    """Δx = s x for points x in the instrument's frame, s dimensionless (1e-6 = 1 ppm).

    Refraction makes 1 ppm per K and 0.27 ppm per hPa. Without a known distance in the data, link lengths
    take it up exactly.
    """

    cause: ClassVar[str] = "tracker_scale"
    title: ClassVar[str] = "Scale of the instrument"
    equation: ClassVar[str] = "Delta x = s thin x"
    separate: ClassVar[dict[str, str]] = {
        "thermal_growth": "a scale bar, or two fixed targets of known distance",
        "geometry": "a scale bar, or two fixed targets of known distance",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("scale", "1", 1e-5, "of all measured distances; 1e-6 is 1 ppm"),)

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        fixed = [target.on for target in problem.campaign.targets if target.fixed]
        if any(fixed.count(on) > 1 for on in fixed):
            off = contradicted(problem)
            if off is None:
                return None
            return (
                f"distances between calibrated targets are up to {1e3 * off:.3f} mm off what is stated, and "
                "no one scale makes them right: look at their places"
            )
        return (
            "no known distance: link lengths take up a scale; state two targets of one link "
            "as calibrated (fixed = true), or measure a scale bar"
        )

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[TrackerScale]:
        return [cls()]

    def seen(self, problem: Problem, points: Array) -> Array:
        return points[..., None]

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        away = np.linalg.norm(np.nanmean(rest.points, axis=1), axis=1)
        return Drawn(away, "distance from the instrument", "m", values[0] * away, "error of distance", "m")

    def sentence(self, values: Array) -> str:
        return f"The instrument's scale is off by {values[0] * 1e6:.1f} ppm."
