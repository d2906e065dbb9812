"""What Liu, Song, Li, Pan, Yu, “Multi-Parameter Based Calibration of Long-Link Flexible Manipulators”, print,
and where it stands there."""

from __future__ import annotations

import numpy as np

from workbench import Array, by_joint

UNIT = np.array([np.pi / 180, np.pi / 180, 1e-3, 1e-3])
"""[rad, rad, m, m] per unit of Tables II and III: θ and α in degrees, a and d in mm."""

TABLE_1 = 1e6 * np.array([148.2, 621.2, 132.7, 211.3, 466.1, 0.09, 0.71])
"""[N·m²] Table I: EI of the links, there in N·m/rad."""

TABLE_2 = UNIT * [
    (0, -90, 340, 0), (0, 0, 1200, 0), (0, 90, 192.5, 0), (0, -90, 1020, 0),
    (0, 90, 138, 0), (90, 90, 0, 0), (-90, 0, 0, 965),
]  # fmt: skip
"""[rad, rad, m, m] Table II: θ, α, a, d as designed."""

TABLE_3 = UNIT * [
    (0.23, -90.54, 340.82, 0.03), (0.20, 0.02, 1200.48, -0.06), (0.18, 90.05, 193.87, 0.04),
    (0.19, -90.08, 1020.14, 0.08), (-0.07, 89.91, 138.31, 0.14), (90.15, 90.03, 0.23, -0.03),
    (-89.94, 0.02, 0.15, 964.12),
]  # fmt: skip
"""[rad, rad, m, m] Table III: θ, α, a, d as calibrated."""

BEFORE, AFTER = 25.42779, 1.78118
"""[mm] section V, below figure VII: mean error on the points that judge, before and after calibration."""

FITTED, JUDGED = 13, 12
"""[1] section V: points that are fitted, and that judge."""


def by_name() -> dict[str, float]:
    """The printed numbers by the names that the story calls them by: angles in °, lengths in mm."""
    named = {"printed_before_mm": BEFORE, "printed_after_mm": AFTER, **by_joint("ei", TABLE_1 / 1e6)}
    for which, table in {"ii": TABLE_2, "iii": TABLE_3}.items():
        for letter, column in zip(("theta", "alpha", "a", "d"), in_print(table).T, strict=True):
            named |= by_joint(f"{letter}_{which}", column)
    named["alpha_off_1"] = named["alpha_iii_1"] - named["alpha_ii_1"]
    return {**named, "d_iii_23": named["d_iii_2"] + named["d_iii_3"]}


def in_print(table: Array) -> Array:
    """(7, 4) a table of θ, α, a, d in the units of print: ° and mm."""
    return np.asarray(table / UNIT)


NUMBERS = by_name()
