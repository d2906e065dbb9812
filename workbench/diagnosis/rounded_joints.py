"""Joints written down with too few digits."""

from __future__ import annotations

import numpy as np

from ..identification.fit import Fit
from .remainder import Remainder
from .result import FaultFound, Noise

STEPS = (1.0, 0.5, 0.1, 0.05, 0.01)  # degrees
MADE_BY_ROUNDING = (0.4, 2.5)  # times the scatter left over that rounding must make to be suspected of it


def rounded_joints(final: Fit, noise: Noise, left: Remainder) -> tuple[FaultFound, ...]:
    """Joints that are multiples of a step which alone would make the scatter that is left.

    Commands are often round numbers and then exact; only unexplained scatter makes them suspect.
    """
    if not left.scatter:
        return ()
    problem = final.model.problem
    lever = np.sqrt(np.mean(final.line.by_joint**2, axis=(0, 1)))
    excess = left.excess(noise.sigma_mm * 1e-3)
    least, most = MADE_BY_ROUNDING
    for step in STEPS:
        turns = np.degrees(problem.q) / step
        round_ = np.abs(turns - np.round(turns)).max(axis=0) < 1e-6
        made = float(
            np.sqrt(np.sum((lever * np.radians(step) / np.sqrt(12))[round_ & ~problem.arm.prismatic] ** 2))
        )
        if round_.all() and least * excess < made < most * excess:
            what = f"all joints are multiples of {step:g}°, which alone scatters {made * 1e3:.3f} mm per axis"
            return (
                FaultFound("rounded_joints", None, None, what, "kept: record the joints with more digits"),
            )
    return ()
