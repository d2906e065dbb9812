"""Charts that many studies draw: values with intervals by row, curves, histograms.

A series is a label and its numbers; its colour is that of its place: `PRINTED` for what a paper prints,
`OURS` for what was computed, or any colour of `drawing`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .drawing import AFTER, BEFORE, INK, MIDDLE, MODEL, MUTED, NOISE, Array, Figure, dots, drawing, plain_log

PRINTED, OURS = BEFORE, AFTER
COLOURS = (AFTER, BEFORE, NOISE, MIDDLE, MODEL)
CURVE_POINTS = 2000  # of a curve, at most


@dataclass(frozen=True)
class Series:
    """Numbers of one colour. values: (R,) by row, or (K,) along x; low, high: ends of their intervals;
    style: "-", "--", "o" or "o-"."""

    values: ArrayLike
    low: ArrayLike | None = None
    high: ArrayLike | None = None
    colour: str = ""
    style: str = "-"


def rows(
    name: str,
    title: str,
    names: Sequence[str],
    series: Mapping[str, Series],
    label: str,
    log: bool = False,
) -> Figure:
    """One row per name, a dot per series with its interval as a line; NaN draws nothing."""
    shift = np.linspace(-0.16, 0.16, len(series)) if len(series) > 1 else np.zeros(1)
    with drawing(name, 0.95 + 0.34 * len(names)) as (axes, svg):
        for k, (colour, (key, given)) in enumerate(zip(_colours(series), series.items(), strict=True)):
            at = np.arange(len(names)) + shift[k]
            values = np.asarray(given.values, dtype=float)
            if given.low is not None and given.high is not None:
                axes.hlines(at, np.asarray(given.low), np.asarray(given.high), color=colour, lw=2, alpha=0.45)
            axes.plot(values, at, "o", color=colour, ms=5.5, mec="none", label=key)
        if log:
            axes.set_xscale("log")
            plain_log(axes.xaxis)
        axes.set(yticks=range(len(names)), ylim=(len(names) - 0.5, -0.6), xlabel=label)
        axes.set_yticklabels(names, color=INK)
        axes.grid(axis="y", visible=False)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(series))
    said = "; ".join(f"{row}: {_said(series, i)}" for i, row in enumerate(names))
    return Figure(name, title, f"{label}. {said}", svg[0])


def curves(
    name: str,
    title: str,
    x: ArrayLike,
    series: Mapping[str, Series],
    xlabel: str,
    ylabel: str,
    log: bool = False,
    height: float = 2.7,
) -> Figure:
    """Curves over a common x (K,); intervals as bands, of "o" series as bars, side by side where x counts."""
    at = np.asarray(x, dtype=float)
    counts = bool((at == np.round(at)).all())
    shift = np.linspace(-0.06, 0.06, len(series)) if counts and len(series) > 1 else np.zeros(len(series))
    with drawing(name, height) as (axes, svg):
        for k, (colour, (key, given)) in enumerate(zip(_colours(series), series.items(), strict=True)):
            bars = "o" in given.style and given.low is not None
            _curve(axes, at + bars * shift[k], given, colour, key)
        if log:
            axes.set_yscale("log")
            plain_log(axes.yaxis)
        axes.set(xlabel=xlabel, ylabel=ylabel)
        axes.margins(x=0.02)
        if counts:
            from matplotlib.ticker import MaxNLocator

            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        columns = len(series) if len(series) < 5 else 3
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=columns)
    return Figure(name, title, f"{ylabel} over {xlabel}: {', '.join(series)}", svg[0])


def histogram(
    name: str,
    title: str,
    values: ArrayLike,
    label: str,
    marks: Mapping[str, float],
    log: bool = False,
) -> Figure:
    """How values (M,) are spread, with named marks as upright lines."""
    given = np.asarray(values, dtype=float)
    ends = [*given, *marks.values()]
    edges = (np.geomspace if log else np.linspace)(min(ends), max(ends), 46)
    with drawing(name, 2.5) as (axes, svg):
        share = 100 * np.histogram(given, edges)[0] / max(len(given), 1)
        axes.stairs(share, edges, fill=True, alpha=0.35, color=MIDDLE)
        axes.stairs(share, edges, color=MIDDLE, lw=1.2)
        for colour, (key, value) in zip((BEFORE, AFTER, NOISE, MODEL), marks.items(), strict=False):
            axes.axvline(value, color=colour, lw=2, label=key)
        if log:
            axes.set_xscale("log")
            plain_log(axes.xaxis)
        axes.set(xlabel=label, ylabel="% of cases", ylim=(0, None))
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=max(len(marks), 1))
    said = "; ".join(f"{key}: {value:.4g}" for key, value in marks.items())
    return Figure(name, title, f"{label}, {len(given)} cases. {said}", svg[0])


@dataclass(frozen=True)
class Bar:
    """A row of a tornado chart: its number at both ends of what it stands for, and a note beside it."""

    name: str
    low: float
    high: float
    note: str = ""


def tornado(
    name: str, title: str, bars: Sequence[Bar], middle: tuple[float, float, float], label: str
) -> Figure:
    """How far a number moves with each of several things, widest first; middle: its 5, 50 and 95 %."""
    with drawing(name, 0.95 + 0.42 * max(len(bars), 1)) as (axes, svg):
        at = np.arange(len(bars))
        low, centre, high = middle
        axes.axvspan(low, high, color=MIDDLE, alpha=0.15, lw=0, label="all draws, 5 to 95 %")
        axes.axvline(centre, color=MODEL, lw=1.2, label="median")
        for colour, words, ends in ((BEFORE, "lowest third", "low"), (AFTER, "highest third", "high")):
            width = [getattr(bar, ends) - centre for bar in bars]
            axes.barh(at, width, left=centre, height=0.55, color=colour, alpha=0.8, label=words)
        for row, bar in enumerate(bars):
            axes.annotate(bar.note, (1.01, row), xycoords=("axes fraction", "data"), va="center", color=MUTED)
        axes.set(yticks=at, ylim=(len(bars) - 0.5, -0.6), xlabel=label)
        axes.set_yticklabels([fill(bar.name, 44) for bar in bars], color=INK)
        axes.grid(axis="y", visible=False)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    said = "; ".join(f"{bar.name}: {bar.low:.3g} to {bar.high:.3g}" for bar in bars)
    return Figure(name, title, f"{label}, median {middle[1]:.3g}. {said}", svg[0])


@dataclass(frozen=True)
class Trace:
    """A line in a plane: x, y (K,), its colour, and its style."""

    x: ArrayLike
    y: ArrayLike
    colour: str = MODEL
    style: str = "-"


def plane(
    name: str,
    title: str,
    series: Mapping[str, Trace],
    xlabel: str,
    ylabel: str,
) -> Figure:
    """Lines in a plane with equal scales: a path seen from above."""
    with drawing(name, 4.2) as (axes, svg):
        for key, line in series.items():
            axes.plot(line.x, line.y, line.style, color=line.colour, lw=1.4, label=key)
        axes.set(xlabel=xlabel, ylabel=ylabel, aspect="equal")
        axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return Figure(name, title, f"{ylabel} over {xlabel}: {', '.join(series)}", svg[0])


def _colours(series: Mapping[str, Series]) -> list[str]:
    """Their own, else the next that none of them has."""
    own = [given.colour for given in series.values()]
    free = iter([colour for colour in COLOURS if colour not in own])
    return [colour or next(free) for colour in own]


def _curve(axes: Any, x: Array, given: Series, colour: str, key: str) -> None:
    step = max(1, -(-len(x) // CURVE_POINTS))
    x, y = x[::step], np.asarray(given.values, dtype=float)[::step]
    low, high = (None if end is None else np.asarray(end)[::step] for end in (given.low, given.high))
    if given.style == "o" and len(x) > 60:
        dots(axes, x, y, colour, key)
        return
    if low is not None and high is not None:
        if "o" in given.style:
            axes.vlines(x, low, high, color=colour, lw=2, alpha=0.45)
        else:
            axes.fill_between(x, low, high, color=colour, alpha=0.2, lw=0)
    marker = {"ms": 5, "mec": "none"} if "o" in given.style else {}
    axes.plot(x, y, given.style, color=colour, lw=1.5, label=key, **marker)


def _said(series: Mapping[str, Series], i: int) -> str:
    return ", ".join(f"{key} {np.asarray(s.values, dtype=float)[i]:.3g}" for key, s in series.items())
