"""What the homework on calibrating a cylindrical robot prints (2020), and where it stands there."""

from __future__ import annotations

import numpy as np

from workbench import by_joint

TABLE_1 = np.array([1e6, 2e6, 0.5e6])
"""[N·m/rad, N/m, N/m] Table 1: the stiffnesses that made the paper's data (all printed in N/m)."""

TABLE_2 = np.array([7.8e5, 20.9e5, 5.2e5])
"""[N·m/rad, N/m, N/m] Table 2: the stiffnesses that it identified."""

ROUNDING = np.full(3, 0.1e5 / np.sqrt(12))
"""[N·m/rad, N/m, N/m] Table 2: what its two or three digits leave open."""

SAME = 0.01
"""[1] Conclusions, section before the last: without noise "same coefficients"; read as to a hundredth."""

CIRCLE_ERROR, CIRCLE_ERROR_SD = 1e-3, 0.25e-3
"""[m] Compensation, before figure 5: "about 1 millimeter"; read as within a quarter."""

SIGMA = 1e-5
"""[m] Measurements, before equation (5): noise of a deflection."""

NOISE_ROUNDING = 0.3e-5
"""[m] Measurements, before equation (5): what the one digit of the noise leaves open."""

POSES = 50
"""[1] after equation (8): number of experiments."""

FORCE = np.array([500.0, -250.0, 1000.0])
"""[N] Compensation, before figure 5: the load under which the circle is drawn."""

NUMBERS = {
    **by_joint("true", TABLE_1),
    **by_joint("printed", TABLE_2),
    **by_joint("printed", TABLE_2 / TABLE_1 - 1, "_off"),
    "printed_largest_off": float(np.abs(TABLE_2 / TABLE_1 - 1).max()),
    "noise_stated_mm": 1e3 * SIGMA,
    "poses": float(POSES),
    **{f"force_{axis}": float(f) for axis, f in zip("xyz", FORCE, strict=True)},
}
