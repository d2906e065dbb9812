"""The figures of the long-link study, and the one table whose rows the numbers choose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.report.charts import OURS, PRINTED, Series, curves, histogram, rows
from workbench.report.drawing import MIDDLE, NOISE, Figure
from workbench.report.numbers import decimals, mm, percent
from workbench.report.study import Table
from workbench.robot.kinematics import Array

Items = dict[str, Table | Figure]
SEEN = 0.1  # µm; less is not drawn


def tables_figure(size: Array, before: float) -> Figure:
    """Tip differences of the two tables, size: (N,) [mm], against the printed mean error."""
    title = (
        f"Geometry alone moves the tip by {mm(size.mean())} mm on average; the paper prints {mm(before)} mm"
    )
    marks = {"printed mean of 12 points": before, "mean of the two tables": float(size.mean())}
    return histogram("tables", title, size, "tip difference, joints within ±90°, mm", marks)


def entries_table(sizes: Mapping[str, float], shares: Mapping[str, float]) -> Table:
    """The six entries of Table III that move the tip most, then all by kind; sizes [mm], shares: by entry."""
    largest = sorted(sizes, key=lambda name: -sizes[name])[:6]
    lines = [[name, mm(sizes[name]), percent(shares[name], 0)] for name in largest]
    for kind in "θαad":
        share = sum(share for name, share in shares.items() if name[0] == kind)
        lines.append([f"all {kind}", "", percent(share, 0)])
    note = "Share: the part of the whole difference along itself; all entries together make 100 %."
    what = "Which entries of Table III make it, joints within ±90°"
    return Table(what, ("Entry", "Alone, mm", "Share"), lines, note)


def budget_figure(size: Mapping[str, Array], sag: float) -> Figure:
    """Motions of the tip by joint, size: kind → (n,) [mm], which make `sag` [mm] together."""
    series = {}
    for kind, colour in (("torsion", OURS), ("overturning", NOISE), ("link", PRINTED)):
        seen = np.where(1e3 * size[kind] > SEEN, 1e3 * size[kind], np.nan)
        series["link bends" if kind == "link" else kind] = Series(seen, colour=colour)
    names = [f"joint, link {i}" for i in range(1, 8)]
    title = f"With 10 kg the joints as assumed move the tip by {mm(sag)} mm, the links by micrometres"
    return rows("budget", title, names, series, "mean motion of the tip with 10 kg, µm", log=True)


def left_figure(steps: Array, left: Sequence[float], share: float, after: float) -> Figure:
    """Mean error (K,) [mm] that joints with these shares of the compliance leave, and the printed one."""
    series = {
        "d and θ fitted, joints taken as rigid": Series(left, colour=OURS, style="o-"),
        "printed": Series(np.full(len(steps), after), colour=PRINTED, style="--"),
    }
    title = f"Joints with {percent(share, 0)} of the assumed compliance leave the printed {mm(after)} mm"
    label = "share of the assumed compliance of joints and bearings"
    return curves("left", title, steps, series, label, "mean error on 12 points, mm")


def twelve_figure(miss: Mapping[str, Array], noise: float) -> Figure:
    """Errors (12,) [mm] of the points that judge, by model, above the mean length of the noise [mm]."""
    names = {
        "designed": ("Table II", PRINTED),
        "rigid": ("joints taken as rigid", MIDDLE),
        "known": ("deflection known", OURS),
    }
    series = {label: Series(miss[name], colour=c, style="o") for name, (label, c) in names.items()}
    series["noise alone"] = Series(np.full(len(miss["known"]), noise), colour=NOISE, style="--")
    before, left, after = (mm(miss[name].mean()) for name in names)
    title = f"On 12 other points {before} mm become {after} mm, or {left} mm with the joints taken as rigid"
    points = np.arange(1, len(miss["known"]) + 1)
    return curves("twelve", title, points, series, "point", "error, mm", log=True)


def plans_figure(plans: Mapping[str, Array], joints: Sequence[str], gain: float) -> Figure:
    """Smallest detectable excess compliance of each joint, plans: name → (J,) shares of the model's."""
    colours = (PRINTED, MIDDLE, OURS, NOISE)
    series = {name: Series(100 * x, colour=c) for (name, x), c in zip(plans.items(), colours, strict=True)}
    times = decimals(gain, 1)
    title = (
        f"A payload put on and off shows the outer joints {times} times better than as many unloaded points"
    )
    label = "smallest detectable excess compliance, % of the model's"
    return rows("plans", title, [joint.replace("_", " ") for joint in joints], series, label, log=True)
