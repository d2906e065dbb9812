"""A map of the workspace: means over cells, from the side and from above, with what was measured."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robot.kinematics import Array
from .drawing import AFTER, BEFORE, INK, MIDDLE, Figure, drawing

CELLS = 24  # along the longer side
CLASSES: tuple[tuple[str, float], ...] = (
    (AFTER, 0.9), (AFTER, 0.45), (MIDDLE, 0.45), (BEFORE, 0.5), (BEFORE, 0.95),
)  # fmt: skip
BEYOND = 0.5  # side of a cell's square where most of its poses lie outside of what was measured
SAME = np.array([0.8, 0.9, 1.1, 1.2])  # of the median: nearer to it is no other class
VIEWS = ((0, 2), (0, 1))  # x over z, x over y


def workspace_map(
    name: str, title: str, places: Array, value: Array, outside: NDArray[np.bool_], measured: Array
) -> Figure:
    """Cells coloured by the mean of `value` (N,) [m] of the poses at `places` (N, 3) [m]; outside: (N,) the
    pose lies outside of what was measured; what lies inside, some at least, says what the classes are;
    measured: (M, 3) [m] where the campaign was."""
    edges = class_edges(value[~outside])
    with drawing(name, 3.8, columns=2) as (axes, svg):
        for ax, view in zip(axes, VIEWS, strict=True):
            _cells(ax, places[:, view], value, outside, edges)
            at = measured[:, view]
            ax.plot(at[:, 0], at[:, 1], ".", color=INK, ms=2, zorder=3)
            ax.set_xlabel(f"{'xyz'[view[0]]}, m")
            ax.set_ylabel(f"{'xyz'[view[1]]}, m")
            ax.set_aspect("equal", adjustable="datalim")
        _legend(axes[0], edges, bool(outside.any()), bool(len(measured)))
    low, high = (1e3 * float(end(value[~outside])) for end in (np.min, np.max))
    words = f"{title}: {low:.3f} to {high:.3f} mm within what was measured, means over cells"
    return Figure(name, title, words, svg[0])


def class_edges(value: Array) -> Array:
    """(4,) [m] edges of the classes of colour: fifths of the values, to two digits, so far apart that what is
    the same everywhere has one colour."""
    fifths = np.quantile(value, [0.2, 0.4, 0.6, 0.8])
    same = np.median(value) * SAME
    apart = [*np.minimum(fifths, same)[:2], *np.maximum(fifths, same)[2:]]
    return np.array([float(f"{edge:.2g}") for edge in apart])


def class_labels(edges: Array) -> list[str]:
    """What the five classes of colour are, in millimetres."""
    mm = [f"{1e3 * edge:.2g}" for edge in edges]
    return [f"< {mm[0]} mm", *(f"{a} … {b}" for a, b in pairwise(mm)), f"> {mm[-1]} mm"]


def opaque_colours() -> list[str]:
    """The classes' colours as they look on white."""
    from matplotlib.colors import to_hex, to_rgb

    out = []
    for colour, alpha in CLASSES:
        r, g, b = (1 - alpha * (1 - value) for value in to_rgb(colour))
        out.append(to_hex((r, g, b)))
    return out


def _cells(ax: Any, at: Array, value: Array, outside: NDArray[np.bool_], edges: Array) -> None:
    from matplotlib.collections import PolyCollection

    low = at.min(axis=0)
    side = max(float(np.ptp(at, axis=0).max()), 1e-6) / CELLS
    cell, where = np.unique(np.floor((at - low) / side).astype(int), axis=0, return_inverse=True)
    count = np.bincount(where.ravel())
    mean, beyond = (np.bincount(where.ravel(), v) / count for v in (value, outside.astype(float)))
    seen = np.bincount(where.ravel(), ~outside)
    inside = np.bincount(where.ravel(), np.where(outside, 0.0, value)) / np.maximum(seen, 1)
    mean = np.where(beyond > 0.5, mean, inside)
    level = np.searchsorted(edges, mean)
    half = 0.5 * side * np.where(beyond > 0.5, BEYOND, 1.0)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    squares = (low + (cell + 0.5) * side)[:, None] + half[:, None, None] * corners
    for k, (colour, alpha) in enumerate(CLASSES):
        if (level == k).any():
            ax.add_collection(PolyCollection(list(squares[level == k]), facecolors=colour, alpha=alpha, lw=0))
    ax.update_datalim(squares.reshape(-1, 2))
    ax.autoscale_view()


def _legend(ax: Any, edges: Array, some_outside: bool, some_measured: bool) -> None:
    """Classes and marks, under both views."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    marks: Sequence[Any] = [
        Patch(facecolor=colour, alpha=alpha, label=label)
        for (colour, alpha), label in zip(CLASSES, class_labels(edges), strict=True)
    ]
    if some_outside:
        label = "small: mostly outside of what was measured"
        marks = [*marks, Line2D([], [], marker="s", ms=3, lw=0, color=MIDDLE, label=label)]
    if some_measured:
        marks = [*marks, Line2D([], [], marker=".", ms=4, lw=0, color=INK, label="measured poses")]
    ax.figure.legend(handles=marks, loc="outside lower center", ncols=4)
