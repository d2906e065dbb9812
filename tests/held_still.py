"""A robot that is told to stand still."""

from __future__ import annotations

import numpy as np

from workbench.robot.kinematics import Array
from workbench.simulation.closed_loop.motion import PERIOD, Motion


def hold(q: Array, duration: float, side: Array | None = None) -> Motion:
    """Joints q (n,) commanded for a while, come to from `side` (n,)."""
    count = 4 * round(duration / (4 * PERIOD)) + 1
    still = np.zeros((count, len(q)))
    from_side = np.zeros(len(q)) if side is None else side
    return Motion(PERIOD, still + q, still, still, from_side, np.array([duration]))
