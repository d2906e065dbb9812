"""Which stiffnesses a load shows at all: bounds from the 27 poses of one cell."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench import Array, Table, by_joint, numbers

from . import laws
from .named import USUAL
from .printed import MASS, TABLE_1
from .springs import poses_of
from .worlds import GRAVITY, Values, posed, world

NOISE = 20e-6  # m, of a reading, per axis
SIDE = np.array([200.0, 200.0, -400.0])  # N
AWAY = 1.5  # m from axis 1
ON_AXIS = dict.fromkeys(("smr_x", "smr_y", "mass_x", "mass_y"), 0.0)
BESIDE = {"smr_x": 0.08, "smr_y": 0.05, "mass_x": 0.06, "mass_y": -0.04}


def identifiable() -> tuple[Table, dict[str, float]]:
    """Least standard deviations of the stiffnesses by load, and the singular values of a hanging load."""
    down = np.array([0.0, 0.0, -MASS * GRAVITY])
    loads: Mapping[str, tuple[Values, Array]] = {
        "50 kg and SMR on axis 6": (ON_AXIS, down),
        "50 kg beside axis 6": (BESIDE, down),
        "A force from the side": (BESIDE, SIDE),
    }
    found = [bounds({**USUAL, **values}, force) for values, force in loads.values()]
    lines = [
        [f"K{j}", *(numbers.percent(b, 0) if b < 10 else "not seen" for b in row)]
        for j, row in enumerate(zip(*(least for least, _ in found), strict=True), start=1)
    ]
    k1 = TABLE_1[:, 0]
    harm = {"side_least_mm": k1.max(), "side_most_mm": k1.min()}
    table = Table("Least standard deviation of each stiffness from 27 poses", ("", *loads), lines)
    return table, by_joint("singular", found[1][1]) | {
        key: float(1e3 * SIDE[1] * AWAY**2 / k) for key, k in harm.items()
    }


def bounds(values: Values, force: Array) -> tuple[Array, Array]:
    """(n,) least standard deviations of the stiffnesses over their values (Cramér–Rao) under a known
    force (3,) [N], and (n,) singular values of their columns over the noise."""
    w = world(values, np.random.default_rng(0))
    poses = posed(w, w.grid, laws.constant, True)
    used = poses_of(w.cuts["constant"], w.cuts["128"])[0]
    J, torque = poses.J[0][used], np.einsum("nij,i->nj", poses.lever[0][used], force)
    rows = J * torque[:, None] / [values[f"k{j}"] for j in range(1, 7)]
    _, s, V = np.linalg.svd(rows.reshape(-1, 6) / (np.sqrt(2) * NOISE), full_matrices=False)
    return np.sqrt(((V.T / np.maximum(s, 1e-12)) ** 2).sum(axis=1)), s
