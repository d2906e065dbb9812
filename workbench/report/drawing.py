"""How the figures look: their colours, their style, and dots and axes drawn our way.

Text stays text in the SVG. The colours are those of `INK` ... `NOISE` and nothing else, so that the
page can put its own (dark) ones in their place.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
INK, MUTED, GRID = "#1b2430", "#667080", "#dfe3e8"
BEFORE, MIDDLE, AFTER = "#c9622c", "#8e98a6", "#0f6f9f"
MODEL, NOISE = "#1b2431", "#3f7f4f"
MOST_DOTS = 1200
TICK = 1.05  # half the length of a stroke on a logarithmic axis, as a factor
FIGURE_WIDTH = 8.0  # inches

STYLE: dict[str, Any] = {
    "svg.fonttype": "none",
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GRID,
    "axes.labelcolor": MUTED,
    "axes.labelsize": 8.5,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": GRID,
    "ytick.color": GRID,
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "xtick.minor.size": 0,
    "ytick.minor.size": 0,
    "legend.frameon": False,
    "legend.labelcolor": MUTED,
    "legend.fontsize": 8.5,
    "text.color": INK,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "path.simplify": False,
    "text.parse_math": False,
}


@dataclass(frozen=True)
class Figure:
    """A picture and the sentence that it shows. `alt` says it to those who cannot see it; note: how it was
    made, for a reader who reads nothing else."""

    name: str
    title: str
    alt: str
    svg: str
    note: str = ""


@contextmanager
def drawing(name: str, height: float, columns: int = 1, **subplots: bool) -> Iterator[tuple[Any, list[str]]]:
    """Axes in the house's style; on leaving, the figure's SVG stands in the list."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure as Canvas

    svg: list[str] = []
    settings: Any = {**STYLE, "svg.hashsalt": name}
    with mpl.rc_context(settings):
        figure: Any = Canvas(figsize=(FIGURE_WIDTH, height), layout="constrained")
        FigureCanvasSVG(figure)
        axes = figure.subplots(1, columns, **subplots)
        yield axes, svg
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
        svg.append(_short(text.getvalue()))


def _short(svg: str) -> str:
    """The same picture in fewer bytes: two decimals, and a dot as a line of no length."""
    svg = re.sub(r'="[^"]*"', lambda value: re.sub(r"(\d+\.\d\d)\d+", r"\1", value[0]), svg)
    return re.sub(r"M (\S+) (\S+) \nL \1 \2 \n", r"M\1 \2h0", svg)


def cloud(axes: Any, x: Array, y: Array, colour: str) -> None:
    """Dots, and where there are many, the means of twenty classes with twice their standard errors."""
    values = np.unique(x)
    few = len(values) <= 6
    if few:  # sides, loads: dots side by side instead of on top of each other
        spacing = float(np.min(np.diff(values), initial=1.0))
        dots(axes, x + 0.2 * spacing * np.sin(7.3 * np.arange(len(x))), y, colour)
        axes.set_xticks(values)
    else:
        dots(axes, x, y, colour)
    if len(x) < 120 or len(values) < 2:
        return
    edges = None if few else np.quantile(x, np.linspace(0, 1, 21))
    at = np.searchsorted(edges[1:-1], x) if edges is not None else np.searchsorted(values, x)
    count = np.bincount(at)
    used = count > 3
    total = np.maximum(count, 1)
    mean_x, mean_y = (np.bincount(at, v) / total for v in (x, y))
    spread = np.sqrt(np.bincount(at, (y - mean_y[at]) ** 2) / np.maximum(count - 1, 1) / total)
    axes.errorbar(mean_x[used], mean_y[used], 2 * spread[used], fmt="o", color=colour, ms=4.5, elinewidth=1.3,
                  mec="none", zorder=3)  # fmt: skip


def dots(axes: Any, x: Array, y: Array, colour: str, label: str | None = None) -> None:
    """Many dots as one path of round-capped points: a tenth of the size of as many markers."""
    step = max(1, -(-len(x) // MOST_DOTS))
    x, y = x[::step], y[::step]
    path_x = np.column_stack([x, x, np.full(len(x), np.nan)]).ravel()
    path_y = np.column_stack([y, y, np.full(len(y), np.nan)]).ravel()
    size = 3.4 if len(x) < 600 else 2.6
    axes.plot(path_x, path_y, color=colour, lw=size, alpha=0.5, solid_capstyle="round")
    if label:
        axes.plot([], [], "o", color=colour, ms=4, mec="none", label=label)


def ticks(axes: Any, x: Array, y: Array, colour: str, label: str) -> None:
    """Many short upright strokes as one path, on a logarithmic y axis: no dots, even without colour."""
    step = max(1, -(-len(x) // MOST_DOTS))
    x, y = x[::step], y[::step]
    path_x = np.column_stack([x, x, np.full(len(x), np.nan)]).ravel()
    path_y = np.column_stack([y / TICK, y * TICK, np.full(len(y), np.nan)]).ravel()
    axes.plot(path_x, path_y, color=colour, lw=1.6, alpha=0.7, solid_capstyle="butt")
    axes.plot([], [], "|", color=colour, ms=7, mew=1.6, label=label)


def plain_log(axis: Any) -> None:
    """Ticks at 1, 2, 5 of each decade, written without powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())
