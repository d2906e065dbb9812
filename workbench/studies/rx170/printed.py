"""What Olabi, Damak, Béarée, Gibaru, Leleu, “Improving the Accuracy of Industrial Robots by offline
Compensation of Joints Errors” (ICIT 2012), print, and where it stands there."""

from __future__ import annotations

import numpy as np

from workbench import by_joint

TABLE_1 = 1e6 * np.array([0.204, 0.85, 0.57, 0.49, 0.12, 0.005])
"""[N·m/rad] Table I: stiffness of the joints."""

TABLE_2 = {"ra": (0.2032, 0.0459, 0.0312), "rz": (0.2882, 0.2097, 0.1502)}
"""[mm] Table II: R_a and R_z without correction, with that of stiffness, and with that of the gear too."""

SCATTER = 0.03
"""[1] Table II: no scatter is printed; three hundredths of each value are allowed for."""

SWEEP_SPAN, SWEEP_SPAN_SD = 0.03, 0.015
"""[°] section III.d: stiffness error "about many 1/100 of degree", read as three, give or take half."""

GEAR_PEAK, GEAR_PEAK_SD = 0.005, 0.0025
"""[°] section III.d: kinematic error "about many 1/1000 of degree", read as five, give or take half."""

SWEPT, POSES = (-50, 50), 2001
"""[°, 1] section III: ends of joint 2's sweep, and its poses, 0.05° apart."""

SPIRAL = {"start": 0.024, "growth": 0.15}
"""[m, 1/rad] section IV.A: R = start · exp(growth · θ)."""

SPIRAL_TURNS = 2
"""[1] section IV.A: θ ends at 4π."""

HEIGHT = 0.2
"""[m] section IV.A: Z of the spiral's plane."""

SPEED, ACCELERATION = 0.03, 0.1
"""[m/s, m/s²] section IV.A.e: of the spiral."""


def by_name() -> dict[str, float]:
    """The printed numbers by the names that the story calls them by: stiffness in 10⁶ N·m/rad, R in mm."""
    named = by_joint("printed", TABLE_1 / 1e6)
    for r, (none, stiffness, both) in TABLE_2.items():
        named |= {f"printed_{r}_none": none, f"printed_{r}_stiffness": stiffness, f"printed_{r}_both": both}
        named |= {f"printed_{r}_first": 1 - stiffness / none, f"printed_{r}_second": 1 - both / stiffness}
    return named


NUMBERS = by_name()
