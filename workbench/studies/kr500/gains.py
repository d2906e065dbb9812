"""What cells gain, over draws of everything that is not printed: the same cell, robots that differ in
one thing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench import Draws, Figure, InputError, Prior, charts, tornado

from . import laws, priors
from .printed import GAIN
from .summary import equal
from .tried import tried
from .worlds import Law, Values, both, world

ROBOTS: Mapping[str, tuple[str, Law, bool]] = {
    "constant": ("constant stiffness", laws.constant, True),
    "soft": ("soft zone", laws.soft_zone, True),
    "varying": ("stiffness that varies", laws.varying, True),
    "structure": ("bearings and tool tilt", laws.structure, True),
    "bracket": ("bracket shifts", laws.bracket, True),
    "moment": ("constant, moment left out", laws.constant, False),
}
ASSUMED: Mapping[str, Prior] = (
    priors.CELL
    | priors.SPRINGS
    | priors.SOLVER
    | priors.SOFT
    | priors.VARYING
    | priors.STRUCTURE
    | priors.BRACKET
)
KEPT = ("gain", "worse", "raw", "left", "step", "twice", "equal")
SHOWN = 8  # assumptions in a tornado


def gained(values: Values, seed: int) -> dict[str, float]:
    """Of each robot: what 128 cells gain over constant stiffness as measured, what they make of the
    error of one set from the same measurements without noise, the mean errors [mm] without model and
    with constant stiffness, by how much calibration lowers that, how the largest errors of 1 and 2
    cells differ, and in how many of 16 cells K4 and K6 print alike. NaN where the arm does not reach."""
    rng = np.random.default_rng(seed)
    names = [f"{what}_{name}" for name in ROBOTS for what in KEPT]
    try:
        w = world(values, rng)
    except InputError:
        return dict.fromkeys(names, np.nan)
    out: dict[str, float] = {}
    for name, (_, law, moment) in ROBOTS.items():
        one = tried(w, both(w, law, moment), rng, "damped")
        errors = one.errors
        mean = {key: e.mean() for key, e in errors.items()}
        largest = [errors[key].max() for key in ("constant", "2")]
        out |= {
            f"gain_{name}": 1 - mean["128"] / mean["constant"],
            f"worse_{name}": one.mean("128") / one.mean("same"),
            f"raw_{name}": mean["raw"],
            f"left_{name}": mean["constant"],
            f"step_{name}": mean["theory"] - mean["constant"],
            f"twice_{name}": abs(largest[1] / largest[0] - 1),
            f"equal_{name}": float(equal(one.K["16"])),
        }
    return {name: float(out[name]) for name in names}


def reached(draws: Draws) -> Draws:
    """Those in which the arm reaches its box."""
    return draws.only(np.isfinite(draws.numbers["gain_constant"]))


def gains_figure(draws: Draws) -> Figure:
    """What 128 cells gain by robot, 5 to 95 % of the draws, beside the print."""
    low, middle, high = (
        [100 * draws.range(f"gain_{name}")[i] for name in ROBOTS] + [100 * GAIN] for i in range(3)
    )
    rows = [words for words, *_ in ROBOTS.values()] + ["printed"]
    over = [ROBOTS[name][0] for name in ROBOTS if draws.range(f"gain_{name}")[2] > GAIN]
    title = f"Robots whose draws, 5 to 95 %, reach the printed gain: {', '.join(over) or 'none'}"
    series = {"median and 5 to 95 % of the draws": charts.Series(middle, low, high, charts.OURS)}
    return charts.rows("gains", title, rows, series, "what 128 cells gain over constant stiffness, %")


def carried(draws: Draws, number: str, name: str, label: str, factor: float = 1.0) -> Figure:
    """The tornado of a number of the robot whose bracket shifts: the assumptions that carry most of it."""
    shares = draws.carries(number)
    acting = [key for key in shares if key in priors.CELL | priors.SPRINGS | priors.SOLVER | priors.BRACKET]
    first = sorted(acting, key=lambda key: -shares[key])[:SHOWN]
    some = replace(
        draws,
        priors={key: draws.priors[key] for key in first},
        values={key: draws.values[key] for key in first},
    )
    return tornado(some, number, name, label, factor)
