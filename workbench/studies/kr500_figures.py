"""Tables and figures of cells: their stiffness, how it scatters, how many cells the noise allows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arm import Array
from ..cells.count import Trade
from ..cells.left import Left
from ..cells.model import CellModel
from ..report.charts import OURS, Series, curves
from ..report.drawing import NOISE, Figure
from ..report.numbers import decimals, mm, percent, significant, size, words
from ..report.study import Table

MEGA = 1e-6
NOTE = "In 10⁶ N·m/rad. In brackets: not decided, the compliance is uncertain by more than its nominal value."
Known = tuple[Array, Array]  # K (n,) and the uncertainty of each compliance over its nominal value (n,)


def stiffness_text(k: float, std: float) -> str:
    """A stiffness [N·m/rad] in 10⁶ N·m/rad, in brackets where it is not decided."""
    return significant(MEGA * k) if std < 1 else f"({significant(MEGA * k, 2)})"


def stiffness_table(title: str, rows: Mapping[str, Array | Known]) -> Table:
    """One row of stiffnesses [N·m/rad] per name: numbers as printed (n,), or those found with their
    uncertainty."""
    lines = []
    for name, row in rows.items():
        k, std = row if isinstance(row, tuple) else (row, np.zeros(len(row)))
        lines.append([name, *(stiffness_text(*one) for one in zip(k, std, strict=True))])
    return Table(title, ("", *(f"K{j}" for j in range(1, len(lines[0])))), lines, NOTE)


def beside_table(title: str, names: Sequence[str], printed: Array, model: CellModel) -> Table:
    """Printed stiffnesses (cells, n) and those of a model, cell by cell."""
    k, std = model.stiffness
    lines = []
    for name, p, *found in zip(names, printed, k, std, strict=True):
        pairs = zip(p, *found, strict=True)
        lines.append([name, *(f"{stiffness_text(x, 0)} · {stiffness_text(*own)}" for x, *own in pairs)])
    return Table(title, ("Cell", *(f"K{j}" for j in range(1, k.shape[1] + 1))), lines, NOTE)


def scatter_table(title: str, printed: Array, models: Mapping[str, CellModel]) -> Table:
    """How the stiffnesses of the cells differ: as printed (cells, n), and in models."""
    found = {name: model.stiffness for name, model in models.items()}
    first = next(iter(found.values()))
    lines = []
    for j in range(printed.shape[1]):
        ratio = decimals(printed[:, j].max() / printed[:, j].min(), 1)
        every = [printed, *(k for k, _ in found.values())]
        spread = [decimals(float(np.log(np.abs(k[:, j])).std(ddof=1)), 2) for k in every]
        noise = float(np.median(first[1][:, j]))
        lines.append(
            [f"K{j + 1}", ratio, *spread, str(int((first[0][:, j] < 0).sum())), significant(noise, 2)]
        )
    name = next(iter(found))
    head = ("", "Printed, max/min", "Printed, σ of ln K", *(f"Ours {key}" for key in found))
    return Table(title, (*head, f"{name}: negative", "By noise alone, σ/K"), lines)


def left_table(title: str, found: Sequence[Left], most: int = 8) -> Table:
    """The causes that need to be least above their usual size, each at its best form."""
    best: dict[str, Left] = {}
    for one in found:
        best.setdefault(one.effect.label, one)
    lines = [
        [
            words(label).replace("(", ", ").rstrip(")"),
            size(one.size, one.effect.params[0].unit),
            f"{significant(one.times, 2)} ×",
            mm(1e3 * one.raw),
        ]
        for label, one in list(best.items())[:most]
    ]
    return Table(
        title, ("Cause", "Size that leaves it", "Of its usual size", "Mean without model, mm"), lines
    )


def allowed_table(title: str, missing: Trade, shares: Sequence[float]) -> Table:
    """How many cells noise allows, for other sizes of the effect that is missing (shares of it)."""
    lines = []
    for share in shares:
        one = missing.scaled(share)
        error = 1e3 * np.sqrt(one.bias + one.variance)
        best = int(one.best == one.counts[-1]) * " or more"
        lines.append(
            [percent(share, 0), mm(1e3 * np.sqrt(one.bias[0])), *map(mm, error), f"{one.best}{best}"]
        )
    head = ("Of the effect", "Constant leaves", *(f"{int(k)}" for k in missing.counts), "Allowed")
    return Table(
        title,
        head,
        lines,
        "RMS errors in mm with 1, 2, 16 and 128 cells, noise and what is missing together.",
    )


def count_figure(name: str, title: str, constant: Trade, missing: Trade) -> Figure:
    """What finer cells remove where something is missing, and what noise adds there and where nothing is."""
    series = {
        "(b) what the model leaves": Series(1e3 * np.sqrt(missing.bias), colour=OURS),
        "(b) what noise adds": Series(1e3 * np.sqrt(missing.variance), colour=OURS, style="--"),
        "(a) what noise adds": Series(1e3 * np.sqrt(constant.variance), colour=NOISE, style="--"),
    }
    label = "number of cells, as a power of 2 (0: one cell, 7: 128 cells)"
    return curves(name, title, np.log2(missing.counts), series, label, "RMS error, mm", log=True)
