"""Whether a diagnosis names a soft zone from the paper's own measurements: over sizes, boxes and records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from workbench import (
    Array,
    Campaign,
    Draws,
    Figure,
    InputError,
    Outcome,
    Prior,
    StudyRun,
    Table,
    charts,
    diagnose,
    draw_many,
    numbers,
    two_steps,
)

from . import laws, priors
from .in_drake import measured
from .springs import poses_of
from .worlds import Law, Values, World, world

RECORDS = {"constant": 54, "2": 84, "16": 366}  # by the cells whose points are measured
USUAL = {key: prior.middle for key, prior in (priors.CELL | priors.SPRINGS).items()}
ASSUMED: Mapping[str, Prior] = {
    **{key: priors.CELL[key] for key in ("near", "z", "charge", "gas", "sigma", "scatter")},
    **{key: priors.SOFT[key] for key in ("soft_size", "soft_width")},
}
LEADS = {"named": "named, and nothing else", "found": "named or in doubt", "nothing": "nothing missing"}


def at(data: Campaign, w: World, cut: str) -> Campaign:
    """The records at the corners and centres of these cells."""
    used = np.zeros(len(data.poses.q) // 2, dtype=bool)
    used[poses_of(w.cuts[cut], w.cuts["128"]).ravel()] = True
    return two_steps.part(data, np.tile(used, 2))


def campaign(w: World, law: Law, cut: str, seed: int) -> Campaign:
    """What Drake measures at the points of these cells."""
    return measured(w, replace(w.grid, campaign=at(w.grid.campaign, w, cut)), law, seed)


def asked(cut: str, values: Values, seed: int) -> dict[str, float]:
    """What a diagnosis says of a soft zone in joint 2; NaN where the arm does not reach its box.
    reverses: share of the poses in which the torque is below the zone's width."""
    every = {**USUAL, "soft_joint": 0.0, **values}
    try:
        w = world(every, np.random.default_rng(seed))
    except InputError:
        return dict.fromkeys((*LEADS, "reverses"), np.nan)
    said = diagnose(campaign(w, laws.soft_zone, cut, seed), seed=seed).diagnosis
    torque = w.grid.nominal_load.local[:, 2, 5]
    true = [cause for cause in said.causes if cause.label == "lost_motion(joint_2)"]
    alone = said.verdict == "named" and len(said.causes) == len(true) == 1
    return {
        "named": float(alone),
        "found": float(bool(true)),
        "nothing": float(said.verdict == "nothing_missing"),
        "reverses": float((np.abs(torque) < every["soft_width"]).mean()),
    }


def curve(run: StudyRun) -> dict[str, Draws]:
    """By the cells whose points are measured: the same robots each time."""
    count = {"constant": run.draws(10, 1), "2": run.draws(10, 1), "16": run.draws(4, 0)}
    return {
        cut: draw_many(partial(asked, cut), ASSUMED, draws, run, f"named_{cut}")
        for cut, draws in count.items()
        if draws
    }


def curve_figure(found: Mapping[str, Draws]) -> Figure:
    """Share of the robots by what a diagnosis says, over the records."""
    x = [float(RECORDS[cut]) for cut in found]
    series = {words: charts.Series(shares(found, key), style="o-") for key, words in LEADS.items()}
    draws = ", ".join(f"{known(one, 'named').size} at {RECORDS[cut]}" for cut, one in found.items())
    title = f"What a diagnosis says of a soft zone, by the records it gets (robots drawn: {draws})"
    return charts.curves(
        "named", title, np.log2(x), series, "records, as a power of 2", "share of the robots"
    )


def shares(found: Mapping[str, Draws], key: str) -> Array:
    return np.array([share(known(one, key)) for one in found.values()])


def share(held: Array) -> float:
    """Mean, NaN of none."""
    return float(held.mean()) if held.size else np.nan


def known(draws: Draws, key: str) -> Array:
    """(D,) a number where the arm reached its box."""
    return np.asarray(draws.numbers[key][np.isfinite(draws.numbers[key])])


def verdicts_table(outcomes: Mapping[str, Outcome]) -> Table:
    """What a diagnosis says of each account's measurements."""
    lines = []
    for words, one in outcomes.items():
        d = one.diagnosis
        causes = [
            numbers.words(cause.label) + ("" if cause.status == "named" else " (in doubt)")
            for cause in d.causes
        ]
        lines.append(
            [
                words,
                str(d.n_poses),
                numbers.words(d.verdict),
                "; ".join(causes) or "none",
                numbers.p_value(d.remainder_p),
            ]
        )
    head = ("Truth", "Records", "Verdict", "Causes", "What is left, p")
    note = (
        "Measured in Drake at the points of two cells; robot, load and where it hangs are told as they are."
    )
    return Table("What a diagnosis says of each account’s robot", head, lines, note, (1,))
