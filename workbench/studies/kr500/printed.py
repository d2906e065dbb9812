"""What “Variable Parameters Stiffness Identification and Modeling for Positional Compensation of Industrial
Robots” prints, and where it stands there."""

from __future__ import annotations

import numpy as np

EQUATIONS = {
    "(18)": 1e6 * np.array([14.9, 6.03, 5.56, 0.370, 0.252, 0.453]),
    "(19)": 1e6 * np.array([15.6, 6.12, 5.83, 0.459, 0.219, 0.479]),
    "(20)": 1e6 * np.array([14.8, 5.58, 6.81, 0.368, 0.140, 0.206]),
    "(21)": 1e6 * np.array([14.9, 6.81, 4.81, 0.228, 0.399, 0.165]),
}
"""[N·m/rad] equations (18) to (21), there in N·mm/rad: K1 ... K6 without and with calibrated kinematics, and
of two cells."""

TABLE_1 = 1e6 * np.array([
    [10.6, 5.56, 6.40, 0.324, 0.131, 0.204], [6.85, 5.59, 6.29, 0.188, 0.0923, 0.126],
    [8.24, 5.88, 6.04, 0.168, 0.0730, 0.120], [10.1, 7.51, 4.29, 0.183, 0.288, 0.183],
    [1.82, 5.36, 6.80, 0.0627, 0.117, 0.0627], [2.05, 5.39, 8.57, 0.0576, 0.0728, 0.0576],
    [2.51, 5.48, 9.24, 0.0564, 0.0507, 0.0564], [2.64, 6.85, 4.88, 0.0520, 0.205, 0.0520],
    [69.5, 5.04, 6.36, 0.706, 0.142, 0.474], [8.29, 4.95, 6.13, 0.260, 0.0946, 0.180],
    [10.6, 5.42, 5.46, 0.234, 0.110, 0.207], [4.37, 7.32, 4.27, 0.117, 1.16, 0.113],
    [2.70, 4.50, 7.49, 0.122, 0.128, 0.0733], [2.83, 4.70, 8.53, 0.101, 0.0812, 0.0456],
    [2.64, 5.13, 7.38, 0.0762, 0.0811, 0.0360], [2.24, 6.72, 4.39, 0.0562, 0.230, 0.0249],
])  # fmt: skip
"""[N·m/rad] Table 1, there in N·mm/rad: K1 ... K6 of 16 cells."""

CUBICS = [f"{i // 4 + 1}.{i % 4 + 1}" for i in range(16)]
"""[-] Table 1: names of the 16 cells."""

ERRORS = {
    "raw": (0.2567, 0.3244),
    "theory": (0.1104,),
    "constant": (0.1049, 0.1434),
    "2": (0.0989, 0.1434),
    "16": (0.0761, 0.1129),
    "128": (0.0581, 0.0981),
}
"""[mm] section 5.3, figures 6 and 7: mean error that the load causes, and the largest where it is given."""

GAIN = 0.4461
"""[1] abstract and section 5.3: what 128 cells gain over constant stiffness."""

CUTS = {"constant": (1, 1, 1), "2": (1, 2, 1), "16": (2, 4, 2), "128": (4, 8, 4)}
"""[1] section 5.2: cells along each side of the box, of 600, 300 and 150 mm."""

SIZE = (1.2, 0.6, 0.6)
"""[m] section 5.2: sides of the box, the long one first."""

TILTS = (-10.0, 0.0, 10.0)
"""[°] section 5.2: rotations of the tool about its y at each point."""

MASS = 50.0
"""[kg] section 5.1: the load."""


def by_name() -> dict[str, float]:
    """The printed numbers by the names that the story calls them by."""
    means = {f"printed_{key}_mm": values[0] for key, values in ERRORS.items()}
    largest = {f"printed_{key}_max_mm": values[1] for key, values in ERRORS.items() if len(values) > 1}
    k4, k5 = np.abs(EQUATIONS["(19)"] / EQUATIONS["(18)"] - 1)[3:5]
    k1 = np.array([K[0] for K in EQUATIONS.values()])
    halves = np.exp(np.abs(np.log(EQUATIONS["(21)"] / EQUATIONS["(20)"])))
    return {
        **means,
        **largest,
        "printed_gain": GAIN,
        "printed_step_mm": means["printed_theory_mm"] - means["printed_constant_mm"],
        "printed_step_k4": float(k4),
        "printed_step_k5": float(k5),
        "printed_halves_k4": float(halves[3]),
        "printed_halves_k5": float(halves[4]),
        "printed_k1_agree": float(np.log(k1).std(ddof=1)),
        "printed_k1_ratio": float(TABLE_1[:, 0].max() / TABLE_1[:, 0].min()),
        "printed_largest_constant": ERRORS["constant"][1] / ERRORS["constant"][0],
        "printed_largest_128": ERRORS["128"][1] / ERRORS["128"][0],
        "printed_equal": float(sum(K[3] == K[5] for K in TABLE_1)),
    }


NUMBERS = by_name()
