"""Stiffness for each cell from equation (9), by plain least squares or by a damped iteration from a start."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from workbench import Array, cells

from .printed import TILTS
from .worlds import Values

ROUNDS, STEP = 25, 1.0  # of the damped iteration; the most that ln K changes in one
Index = NDArray[np.int64]
Normal = tuple[Array, Array]  # (M, n, n) AᵀA and (M, n) Aᵀd of each pose


@lru_cache(maxsize=16)
def poses_of(cut: tuple[int, int, int], finest: tuple[int, int, int]) -> Index:
    """(cells, 27) numbers of the poses in the grid of the finest cells that each cell is measured in."""
    unit = [[0, 0, 0], [1, 1, 1]]
    every, grid = cells(unit, finest).samples, cells(unit, cut)
    out = []
    for centre in grid.centres:
        corners = centre + grid.size * (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5)
        points = [int(np.abs(every - p).max(axis=1).argmin()) for p in (*corners, centre)]
        out.append([len(TILTS) * i + t for i in points for t in range(len(TILTS))])
    return np.array(out)


def normal(columns: Array, read: Array) -> Normal:
    """What each pose adds to the normal equations; columns (M, 3, n), read (M, 3)."""
    return np.einsum("mij,mik->mjk", columns, columns), np.einsum("mij,mi->mj", columns, read)


def summed(equations: Normal, poses: Index) -> Normal:
    """Of each cell: (C, n, n) and (C, n)."""
    return equations[0][poses].sum(axis=1), equations[1][poses].sum(axis=1)


def plain(equations: Normal, values: Values) -> Array:
    """(C, n) [rad/(N·m)] compliances of least squares, as they come: of any sign."""
    scale = np.sqrt(np.maximum(np.einsum("cjj->cj", equations[0]), 1e-300))
    scaled = equations[0] / (scale[:, :, None] * scale[:, None])
    return np.asarray(np.linalg.solve(scaled, (equations[1] / scale)[:, :, None])[:, :, 0] / scale)


def damped(equations: Normal, values: Values) -> Array:
    """(C, n) [rad/(N·m)] compliances from the least |d − A c|² + λ² |ln K/K₀|²: above zero, and at
    their start where the data say nothing. λ: `damping`; K₀: `start1` ..."""
    N, b = equations
    start = 1 / np.array([values[f"start{j}"] for j in range(1, 7)])
    ridge = values["damping"] ** 2 * np.eye(6)
    x = np.zeros(b.shape)
    for _ in range(ROUNDS):
        c = start * np.exp(x)
        slope = c * (b - (N @ c[:, :, None])[:, :, 0]) - values["damping"] ** 2 * x
        bend = c[:, :, None] * N * c[:, None] + ridge
        x = x + np.clip(np.linalg.solve(bend, slope[:, :, None])[:, :, 0], -STEP, STEP)
    return np.asarray(start * np.exp(x))


def of_points(points: Array, box: Array, cut: tuple[int, int, int], found: Array) -> Array:
    """(M, n) the compliances found (C, n) of the cell that each point (M, 3) [m] lies in."""
    return np.asarray(found[cells(box, cut).of(points)])
