"""The figures of the long-link study, and the one table whose rows the numbers choose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from workbench import Array, Figure, Table, charts, numbers


class Chapter(NamedTuple):
    """What a chapter found: numbers, tables and figures by the names that the story calls them by."""

    numbers: dict[str, float]
    items: dict[str, Table | Figure]


SEEN = 0.1  # µm; less is not drawn


def tables_figure(size: Array, before: float) -> Figure:
    """Tip differences of the two tables, size: (N,) [mm], against the printed mean error."""
    ours, theirs = numbers.mm(size.mean()), numbers.mm(before)
    title = f"Tables II and III differ by {ours} mm at the tip, by construction about the printed {theirs} mm"
    marks = {"printed mean of 12 points": before, "mean of the two tables": float(size.mean())}
    return charts.histogram("tables", title, size, "tip difference, joints within ±90°, mm", marks)


def entries_table(sizes: Mapping[str, float], shares: Mapping[str, float]) -> Table:
    """The six entries of Table III that move the tip most, then all by kind; sizes [mm], shares: by entry."""
    largest = sorted(sizes, key=lambda name: -sizes[name])[:6]
    lines = [[name, numbers.mm(sizes[name]), numbers.percent(shares[name], 0)] for name in largest]
    for kind in "θαad":
        share = sum(share for name, share in shares.items() if name[0] == kind)
        lines.append([f"all {kind}", "", numbers.percent(share, 0)])
    note = "Share: the part of the whole difference along itself; all entries together make 100 %."
    what = "Which entries of Table III make it, joints within ±90°"
    return Table(what, ("Entry", "Alone, mm", "Share"), lines, note)


def budget_figure(size: Mapping[str, Array], sag: float) -> Figure:
    """Motions of the tip by joint, size: kind → (n,) [mm], which make `sag` [mm] together."""
    series = {}
    for kind, colour in (("torsion", charts.OURS), ("overturning", charts.NOISE), ("link", charts.PRINTED)):
        seen = np.where(1e3 * size[kind] > SEEN, 1e3 * size[kind], np.nan)
        series["link bends" if kind == "link" else kind] = charts.Series(seen, colour=colour)
    names = [f"joint, link {i}" for i in range(1, 8)]
    title = f"With 10 kg the joints as assumed move the tip by {numbers.mm(sag)} mm, the links by micrometres"
    return charts.rows("budget", title, names, series, "mean motion of the tip with 10 kg, µm", log=True)


def twelve_figure(miss: Mapping[str, Array], noise: float) -> Figure:
    """Errors (12,) [mm] of the points that judge, by model, above the mean length of the noise [mm]."""
    names = {
        "designed": ("Table II", charts.PRINTED),
        "rigid": ("joints taken as rigid", charts.MIDDLE),
        "known": ("deflection known", charts.OURS),
    }
    series = {label: charts.Series(miss[name], colour=c, style="o") for name, (label, c) in names.items()}
    series["noise alone"] = charts.Series(np.full(len(miss["known"]), noise), colour=charts.NOISE, style="--")
    before, left, after = (numbers.mm(miss[name].mean()) for name in names)
    title = f"On 12 other points {before} mm become {after} mm, or {left} mm with the joints taken as rigid"
    points = np.arange(1, len(miss["known"]) + 1)
    return charts.curves("twelve", title, points, series, "point", "error, mm", log=True)


def plans_figure(plans: Mapping[str, Array], joints: Sequence[str], gain: float) -> Figure:
    """Smallest detectable excess compliance of each joint, plans: name → (J,) shares of the model's."""
    colours = (charts.PRINTED, charts.MIDDLE, charts.OURS, charts.NOISE)
    series = {
        name: charts.Series(100 * x, colour=c) for (name, x), c in zip(plans.items(), colours, strict=True)
    }
    times = numbers.decimals(max(gain, 1 / gain), 1)
    than = "smaller" if gain > 1 else "larger"
    title = (
        f"With a payload put on and off, what shows of the outer joints is {times} times {than} than with as "
        "many unloaded points"
    )
    label = "smallest detectable excess compliance, % of the model's"
    return charts.rows("plans", title, [joint.replace("_", " ") for joint in joints], series, label, log=True)
