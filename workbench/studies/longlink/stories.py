"""The accounts of the printed errors and of Table III: what may have made them, each with its free values."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from workbench import Account, Array, Item, Prior

from .linear import ALPHA, RANGES, THETA, A, Calibrated, D, Wrong, calibrated, pool
from .printed import AFTER, BEFORE, FITTED, JUDGED, TABLE_2, TABLE_3

Values = Mapping[str, float]
DEGREE, MM = np.pi / 180, 1e-3
TAILS = 3.0  # degrees of freedom of the errors of a table: some are large
log = partial(Prior, log=True)


def sizes(table: Array) -> dict[str, Array]:
    """How large a table (7, 4) [rad, m] of corrections is: |α₁|, and the root mean square of the other twists
    [°], of the lengths, zeros [°] and offsets [mm]; the entries that no account prints apart (a₇, α₇, θ₇)
    left out."""

    def rms(part: Array) -> float:
        return float(np.sqrt((part**2).mean()))

    return {
        "alpha_1": np.array([abs(table[0, ALPHA]) / DEGREE]),
        "twists": np.array([rms(table[1:6, ALPHA]) / DEGREE]),
        "lengths": np.array([rms(table[:6, A]) / MM]),
        "zeros": np.array([rms(table[:6, THETA]) / DEGREE]),
        "offsets": np.array([rms(table[:, D]) / MM]),
    }


TOLERANCE = 0.1  # of each number: nearer than that no arm drawn at random need come
PRINTED = sizes(TABLE_3 - TABLE_2)
ITEMS = tuple(
    Item(name, words, value, TOLERANCE * np.asarray(value), place, ratio=True)
    for name, words, value, place in (
        ("before", "before", BEFORE, "section V"),
        ("after", "after", AFTER, "section V"),
        ("alpha_1", "|α₁|", PRINTED["alpha_1"], "Tables II, III"),
        ("twists", "twists", PRINTED["twists"], "Tables II, III"),
        ("lengths", "lengths", PRINTED["lengths"], "Tables II, III"),
        ("zeros", "zeros", PRINTED["zeros"], "Tables II, III"),
        ("offsets", "offsets", PRINTED["offsets"], "Tables II, III"),
    )
)

COMMON = {
    "range": Prior(
        "range of the joints, one of ±30, 45, 60, 90, 120°", 0, len(RANGES), why="poses are not printed"
    ),
    "floor": Prior("poses above the floor only (below ½) or any", 0, 1, why="not printed"),
    "noise": log("noise per axis", 0.02, 0.1, "mm", why="a laser tracker"),
    "circle_twist": log("error of twists from circles", 0.002, 0.02, "°", why="three points each"),
    "circle_length": log("error of lengths from circles", 0.02, 0.2, "mm", why="three points each"),
}
GEOMETRY = {
    "angle": log("errors of θ and α", 0.03, 0.5, "°", why="assembly"),
    "length": log("errors of a and d", 0.05, 1.0, "mm", why="machining"),
}
YIELDING = {
    "compliance": log("compliance of joints over what is assumed", 0.03, 3, why="no data"),
    "bearing": log(
        "overturning over that, d₁/(d₁ + d₂) included",
        0.2,
        2,
        why="(14), (15): the bearing's share is not printed",
    ),
}
OWN: dict[str, tuple[str, dict[str, Prior]]] = {
    "compensated": (
        "authors: joints yield, compensated",
        {
            **GEOMETRY,
            **YIELDING,
            "missed": Prior("share of the sag that is not compensated", 0, 0.3, why="data sheets"),
        },
    ),
    "links": (
        "authors: links bend",
        {**GEOMETRY, "links": log("bending over Table I's", 1, 3000, why="Table I is implausibly stiff")},
    ),
    "yielding": ("joints yield, not compensated", {**GEOMETRY, **YIELDING}),
    "ratios": (
        "ratios off",
        {**GEOMETRY, "ratio": log("error of a ratio", 1e-5, 3e-3, why="from three points")},
    ),
    "circles": (
        "poor circles",
        {
            **GEOMETRY,
            "circle_twist": log("error of twists from circles", 0.01, 0.2, "°", why="three points, and sag"),
            "circle_length": log("error of lengths from circles", 0.1, 1, "mm", why="three points, and sag"),
        },
    ),
    "noisy": (
        "noisy points",
        {**GEOMETRY, "noise": log("noise per axis", 0.1, 3, "mm", why="an arm that swings")},
    ),
    "sag": (
        "sag alone",
        {**YIELDING, "compliance": log("compliance of joints over what is assumed", 0.1, 10, why="no data")},
    ),
}  # fmt: skip
"""[-] account → its words and its own free values, which replace common ones of the same name."""


def wrong(name: str, v: Values, rng: np.random.Generator) -> Wrong:
    """What an account says is wrong with the arm."""
    table = np.zeros((7, 4))
    if name != "sag":
        scale = np.array([v["angle"] * DEGREE, v["angle"] * DEGREE, v["length"] * MM, v["length"] * MM])
        table = scale * rng.standard_t(TAILS, (7, 4))
    each = v.get("compliance", 0.0) * np.exp(0.3 * rng.normal(size=7))
    circle = np.zeros((7, 4))
    circle[:, ALPHA] = v["circle_twist"] * DEGREE * rng.normal(size=7)
    circle[:, A] = v["circle_length"] * MM * rng.normal(size=7)
    return Wrong(
        table,
        each,
        each * v.get("bearing", 0.0),
        np.full(7, v.get("links", 0.0)),
        v.get("ratio", 0.0) * rng.normal(size=7),
        circle,
        1 - v["missed"] if "missed" in v else 0.0,
        v["noise"] * MM,
    )


def told(name: str, v: Values, rng: np.random.Generator) -> Calibrated:
    """A draw of an account, measured and calibrated as in the paper."""
    where = pool(RANGES[int(v["range"])], v["floor"] < 0.5)
    return calibrated(where, wrong(name, v, rng), FITTED, JUDGED, rng)


def predicted(name: str, v: Values, rng: np.random.Generator) -> dict[str, Array]:
    """What the paper would have printed."""
    found = told(name, v, rng)
    means = {k: np.array([mean_mm(x)]) for k, x in (("before", found.before), ("after", found.after))}
    return means | sizes(found.table)


def mean_mm(errors: Array) -> float:
    """Mean length [mm] of errors (N, 3) [m]."""
    return float(1e3 * np.linalg.norm(errors, axis=1).mean())


def accounts() -> list[Account]:
    """All of them, the authors' own first."""
    return [
        Account(name, words, {**COMMON, **priors}, partial(predicted, name))
        for name, (words, priors) in OWN.items()
    ]
