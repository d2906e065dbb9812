"""How Table II may have come to be: accounts that differ in where z = 0 is, and in which joints err.

All share the arm: what pulls at joint 2, its gear, how well both were known, the other joints, the tracker.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from workbench import Account, Array, Draws, Item, Prior, StudyRun, draw_many

from .printed import (
    GEAR_PEAK,
    GEAR_PEAK_SD,
    SCATTER,
    SWEEP_SPAN,
    SWEEP_SPAN_SD,
    TABLE_2,
)
from .superposed import PLACES, UNIT, heights_at, sweep_span

Values = Mapping[str, float]
LEFT = "share of the gear's error that its fundamental is not"
OWN = "a real robot has them"

ARM = {
    "place": Prior(
        "spiral's place before axis 1", PLACES[0], PLACES[-1], "m", why="Fig. 12 gives no numbers"
    ),
    "yields": Prior(
        "yield of joint 2 over the model's", 0.2, 4.0, log=True, why="masses and spring not given"
    ),
    "spring": Prior("yield in the sweep over that on the spiral", 0.4, 2.5, log=True, why="spring not given"),
    "gear": Prior("gear amplitude of joint 2", 5e-6, 2e-4, "rad", True, "“many 1/1000 of degree”"),
    "known": Prior("stiffness times torque taken for the yield", 0.7, 1.3, why="no uncertainty given"),
    "left": Prior(LEFT, 0.0, 0.9, why="Fig. 11 shows one line only"),
    "noise": Prior("noise of a tracker reading on the move", 1e-3, 3e-2, "mm", True, "not given"),
}
OTHERS = {
    "sag": Prior("yield of the other joints over the model's", 0.05, 3.0, log=True, why="masses not given"),
    "gears": Prior("gear amplitude of joints 3 and 5", 5e-6, 2e-4, "rad", True, OWN),
}
ITEMS = (
    Item("ra", "Ra, three runs", TABLE_2["ra"], SCATTER * np.array(TABLE_2["ra"]), "Table II", ratio=True),
    Item("rz", "Rz, three runs", TABLE_2["rz"], SCATTER * np.array(TABLE_2["rz"]), "Table II", ratio=True),
    Item("sweep", "yield in the sweep", SWEEP_SPAN, SWEEP_SPAN_SD, "section III.d", ratio=True),
    Item("peak", "gear error of joint 2", GEAR_PEAK, GEAR_PEAK_SD, "section III.d", ratio=True),
)


def accounts() -> list[Account]:
    """The authors' own first: joint 2 errs, heights count from the robot's base."""
    offset = Prior(
        "height of each run's own zero, up to", 0.01, 0.5, "mm", True, "the frame is measured anew"
    )
    both = {**ARM, **OTHERS}
    return [
        Account("own", "joint 2 alone errs, z from the base", ARM, partial(printed, zero="base")),
        Account("base", "all joints err, z from the base", both, partial(printed, zero="base")),
        Account("sagging", "all joints err, z from the others' sag", both, partial(printed, zero="sag")),
        Account("mean", "all joints err, z from each run's mean", both, partial(printed, zero="mean")),
        Account("level", "all joints err, plane levelled in each run", both, partial(printed, zero="level")),
        Account("anew", "all joints err, zero set anew in each run", {**both, "offset": offset},
                partial(printed, zero="anew")),
    ]  # fmt: skip


def runs(values: Values, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """(3, N) [mm] heights over the base without correction, with that of stiffness, and with both; (N,) what
    the other joints make of them; (N, 3) the plane's columns."""
    h = heights_at(min(PLACES, key=lambda x: abs(x - values["place"])))

    def geared(joint: str, amplitude: float) -> Array:
        phase = rng.uniform(0, 2 * np.pi)
        return np.asarray(h.gear[joint] @ [np.cos(phase), np.sin(phase)]) * amplitude / UNIT

    yields, gear = values["yields"] * h.yield_2, geared("joint_2", values["gear"])
    other = np.zeros(len(yields))
    if "sag" in values:
        wrist = geared("joint_3", values["gears"]) + geared("joint_5", values["gears"])
        other = values["sag"] * h.yield_others + wrist
    none = yields + gear + other
    stiff = none - values["known"] * yields
    both = stiff - (1 - values["left"]) * gear
    seen = np.array([none, stiff, both])
    return seen + rng.normal(scale=values["noise"], size=seen.shape), other, h.plane


def printed(values: Values, rng: np.random.Generator, zero: str) -> dict[str, Array | float]:
    """Table II and what section III says of the sweep. zero: the base, where the others sag to on
    average, each run's mean, its best plane, or a height set anew in each run."""
    z, other, plane = runs(values, rng)
    if zero == "sag":
        z = z - other.mean()
    elif zero == "mean":
        z = z - z.mean(axis=1, keepdims=True)
    elif zero == "level":
        z = z - (plane @ np.linalg.lstsq(plane, z.T)[0]).T
    elif zero == "anew":
        z = z - values["offset"] * rng.uniform(-1, 1, size=(3, 1))
    return {
        "ra": np.abs(z).mean(axis=1),
        "rz": np.ptp(z, axis=1),
        "sweep": sweep_span() * values["yields"] * values["spring"],
        "peak": float(np.degrees(values["gear"])),
    }


def draws(run: StudyRun) -> Draws:
    """Ra and Rz of the last run by where z = 0 is, over all that is assumed."""
    return draw_many(one, {**ARM, **OTHERS}, run.draws(600, 100), run)


def one(values: Values, seed: int) -> dict[str, float]:
    """One draw: Ra [mm] of the last run from three zeros, its Rz as it is and levelled, what both gain."""
    rng = np.random.default_rng(seed)
    z, other, plane = runs(values, rng)
    last = z[2]
    flat = last - plane @ np.linalg.lstsq(plane, last)[0]
    return {
        "ra_base": float(np.abs(last).mean()),
        "ra_sag": float(np.abs(last - other.mean()).mean()),
        "ra_mean": float(np.abs(last - last.mean()).mean()),
        "rz_last": float(np.ptp(last)),
        "rz_flat": float(np.ptp(flat)),
        "rz_gain": float(np.ptp(last) / np.ptp(z[0])),
        "ra_gain": float(np.abs(last - other.mean()).mean() / np.abs(z[0] - other.mean()).mean()),
    }
