"""Whether a campaign was measured while the arm moved."""

from __future__ import annotations

import numpy as np

from ..robot.kinematics import Array

AT_REST = 0.5  # s: no arm stops, settles and is measured in less


def in_motion(q: Array, time: Array | None) -> float:
    """[s] the usual time between rows that were measured while the arm moved, joints q (N, n) [rad, m] and
    time (N,) [s], NaN where it was not recorded; 0 where the arm stood still, or nothing says so."""
    if time is None or len(q) < 2:
        return 0.0
    apart = np.abs(np.diff(time))
    moved = np.any(np.diff(q, axis=0) != 0.0, axis=1) & np.isfinite(apart)
    if not moved.any():
        return 0.0
    usual = float(np.median(apart[moved]))
    return usual if 0.0 < usual < AT_REST else 0.0
