"""What Klimchik, Pashkevich, Caro, Furet, “Calibration of Industrial Robots with Pneumatic Gravity
Compensators” (AIM 2017), print, and where it stands there; and the pressures gauged on a robot of this
class."""

from __future__ import annotations

import numpy as np

TABLE_1 = 1e-6 * np.array([1.13, 0.34, 0.36, 0.35, 0.28, 0.32, 0.26, 0.43, 0.95, 3.82, 4.01])
"""[rad/(N·m)] Table I, there in rad·µm/N: k1, k21 to k26 of joint 2 at six angles, k3 to k6."""

SIX = slice(1, 7)
"""[-] Table I: where joint 2's six stand."""

HALF_1 = 1e-6 * np.array([0.15, 0.004, 0.005, 0.005, 0.007, 0.011, 0.007, 0.007, 0.31, 0.27, 0.35])
"""[rad/(N·m)] Table I, “CI”: half widths of the intervals."""

ROUNDED_1 = 1e-6 * 0.01 / np.sqrt(12)
"""[rad/(N·m)] standard deviation of Table I's rounding."""

ROUNDED_HALF_1 = 1e-6 * 0.001 / np.sqrt(12)
"""[rad/(N·m)] standard deviation of Table I's rounding of the intervals of joints 2 and 3."""

CONFIGURATIONS = 31
"""[1] section IV: configurations in all, from three to seven at each angle."""

LOAD = 120.0
"""[kg] section IV: the load."""

ATMOSPHERE = 1.01e5
"""[Pa] section II: P0."""

MARKERS_APART, MARKERS_BEFORE = 0.46, 0.0755
"""[m] Fig. 2: markers apart from each other, and before the flange."""

KR300_ANGLES = np.radians(np.arange(-120, -39, 10))
"""[rad] Table in the public repository “Robot_Identification” (Weigand, MIT): joint 2 of a KR 300 at
which its gas was gauged."""

KR300_PRESSURES = 1e5 * np.array([170, 167, 164, 162, 164, 170, 180, 190, 200])
"""[Pa] Table there: as gauged."""

KR300_TANKS, KR300_PISTON = 2 * 0.48e-3, float(np.pi / 4 * (0.055**2 - 0.030**2))
"""[m³, m²] Table there: two tanks of 0.48 l, and the ring of a 55 mm piston about a 30 mm rod."""

NUMBERS = {
    "configurations": float(CONFIGURATIONS),
    "points": 6.0 * CONFIGURATIONS,
    "load": LOAD,
    "marker_across_mm": 1e3 * MARKERS_APART / 2,
    "marker_before_mm": 1e3 * MARKERS_BEFORE,
}
