"""The arm as it is simulated: built as Table III, told as Table II, seen by a tracker.

What the paper does not give is assumed here; the story says why.
"""

from __future__ import annotations

import numpy as np

from workbench import SimulatedArm, Target

from .printed import TABLE_2, TABLE_3

SIGMA = 5e-5  # m, laser tracker, per axis
STATION = np.eye(3)[None], np.array([[3.2, -2.4, 0.3]])
BALL = Target("ball", (0.0, 0.0, 0.0), fixed=True)
RING = [
    Target(f"base {k}", (float(np.cos(t)), float(np.sin(t)), -0.85), "base", fixed=True)
    for k, t in enumerate(np.radians(np.arange(0, 360, 60)), start=1)
]
ARM = SimulatedArm(TABLE_2, TABLE_3, STATION, (BALL, *RING), SIGMA, {"gun": (10.0, (0.0, 0.0, 0.1))})
