"""How the printed stiffnesses may have come to be: the authors' account, and what else makes such errors.

All accounts share the arm, the circle and the least squares of eq. (9). Each predicts Table 2, the stiffness
that comes out without noise, the noise, and the error of the circle.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from workbench import Account, Array, Item, Prior

from .deflections import least_squares, pool
from .printed import (
    CIRCLE_ERROR,
    CIRCLE_ERROR_SD,
    FORCE,
    NOISE_ROUNDING,
    POSES,
    ROUNDING,
    SAME,
    SIGMA,
    TABLE_1,
    TABLE_2,
)

Values = Mapping[str, float]
Force = Callable[[Values, np.random.Generator], Array]
ARM = {
    "length": Prior("length of link 2", 0.3, 0.8, "m", why="not given"),
    "centre": Prior("centre of the circle over the reach's middle", 0.8, 1.2, why="not given"),
    "mass": Prior(
        "mass of the links that joint 2 carries", 0.0, 45.0, "kg", why="not given; eq. (5) has none"
    ),
}
ITEMS = (
    Item("table", "Table 2", TABLE_2, ROUNDING, "Table 2", ratio=True),
    Item("same", "no noise: same coefficients", TABLE_1, SAME * TABLE_1, "Conclusions", ratio=True),
    Item("noise", "noise", SIGMA, NOISE_ROUNDING, "Measurements", ratio=True),
    Item("circle", "circle about 1 mm off", CIRCLE_ERROR, CIRCLE_ERROR_SD, "Compensation", ratio=True),
)


def accounts() -> list[Account]:
    """The authors' own first."""
    light = Prior("load over the circle's", 0.003, 1.0, log=True, why="not given")
    newton = Prior("size of each force", 1.0, 1500.0, "N", log=True, why="not given")
    louder = Prior("noise over the stated", 1.0, 300.0, log=True, why="a slip of units or scale")
    longer = Prior("link 2 longer than the program has it", -0.25, 0.25, "m", why="half its length")
    weaker = Prior("force smaller than the program has it", -0.4, 0.4, why="up to four tenths")
    damping = Prior("damping over the normal equations", 1e-3, 10.0, log=True, why="from none to a halt")
    start = Prior("stiffness that the solver starts from, all alike", 2e5, 4e6, "N/m", True, "around Table 1")
    faults = {"longer": longer, "weaker": weaker}
    # name, words, free values of its own, force
    told: list[tuple[str, str, dict[str, Prior], Force]] = [
        ("stated", "noise as stated, the circle's load", {}, full),
        ("light", "noise as stated, a lighter load", {"load": light}, lighter),
        ("random", "noise as stated, forces from all sides", {"newton": newton}, around),
        ("louder", "noise larger than stated", {"louder": louder}, full),
        ("fault", "wrong lever and force", faults, full),
        ("damped", "a damped solver", {"damping": damping, "start": start}, full),
    ]
    return [
        Account(name, words, {**ARM, **own}, partial(fitted, force=force)) for name, words, own, force in told
    ]


def full(_: Values, __: np.random.Generator) -> Array:
    """(3,) [N] the circle's load."""
    return FORCE


def lighter(values: Values, _: np.random.Generator) -> Array:
    return values["load"] * FORCE


def around(values: Values, rng: np.random.Generator) -> Array:
    """(POSES, 3) [N] one size, a direction of its own at each pose."""
    towards = rng.normal(size=(POSES, 3))
    return np.asarray(values["newton"] * towards / np.linalg.norm(towards, axis=1)[:, None])


def fitted(values: Values, rng: np.random.Generator, force: Force) -> dict[str, Array | float]:
    """What the paper would print: eq. (9) on deflections of random poses, with noise and without."""
    arm, length = pool(), values["length"]
    poses = arm.random(rng, POSES, length)
    pulled = force(values, rng)
    believed = arm.rows(poses, pulled)
    truly = believed
    if "longer" in values:
        truly = arm.rows(moved_out(poses, values["longer"]), (1 - values["weaker"]) * pulled)
    moved = truly.sum(axis=2)
    sigma = SIGMA * values.get("louder", 1.0)
    noise = rng.normal(scale=sigma, size=moved.shape)
    damping = values.get("damping", 0.0)
    start = np.full(3, values.get("start", 1e6))
    return {
        "table": least_squares(believed, moved + noise, damping, start),
        "same": least_squares(believed, moved, damping, start),
        "noise": sigma,
        "circle": arm.circle_error(values["centre"] * (length + 0.25), values["mass"]),
    }


def moved_out(poses: Array, longer: float) -> Array:
    """The poses of the pool that lie nearest to these, farther out by `longer` [m]."""
    arm = pool()
    return arm.nearest(arm.reach[poses] + longer, arm.angle[poses])
