"""A box of the workspace cut into equal cells, and where they are measured (Jiao et al. 2020, section 3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...files.faults import Fault, InputError
from ...robot.kinematics import Array

WALL = 1e-6  # m: so near to a wall is in both cells
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Cells:
    """Equal boxes side by side. lower: (3,) [m] their first corner, base frame; size: (3,) [m] of one."""

    lower: Array
    size: Array
    counts: tuple[int, int, int]

    def __len__(self) -> int:
        return int(np.prod(self.counts))

    @property
    def upper(self) -> Array:
        """(3,) [m] the last corner."""
        return np.asarray(self.lower + self.size * self.counts)

    def of(self, points: ArrayLike) -> Index:
        """(N,) number of the cell of each point (N, 3) [m]. Raises `InputError` for points outside."""
        p = np.asarray(points, dtype=np.float64)
        outside = np.flatnonzero(~((p > self.lower - WALL) & (p < self.upper + WALL)).all(axis=1))
        if len(outside):
            first = ", ".join(f"{1e3 * x:.0f}" for x in p[outside[0]])
            what = f"{len(outside)} of {len(p)} are outside the cells, the first at ({first}) mm"
            raise InputError(Fault("points", what, f"the cells fill {_spans(self.lower, self.upper)}"))
        at = np.clip(np.floor((p - self.lower) / self.size).astype(np.int64), 0, np.array(self.counts) - 1)
        return np.asarray(np.ravel_multi_index(tuple(at.T), self.counts), dtype=np.int64)

    def holds(self, cell: int, points: Array) -> NDArray[np.bool_]:
        """(N,) whether points are in a cell; those on a wall are in both."""
        low = self.lower + self.size * self._corner(cell)
        return np.asarray(((points > low - WALL) & (points < low + self.size + WALL)).all(axis=1))

    def name(self, cell: int) -> str:
        """The cell for people: its number and where it lies."""
        low = self.lower + self.size * self._corner(cell)
        return f"cell {cell + 1} ({_spans(low, low + self.size)})"

    @property
    def samples(self) -> Array:
        """(M, 3) [m] eight corners and the centre of every cell, a corner that cells share only once."""
        corners = np.indices([count + 1 for count in self.counts]).reshape(3, -1).T
        return np.vstack([self.lower + self.size * corners, self.centres])

    @property
    def centres(self) -> Array:
        """(cells, 3) [m] the centre of each cell."""
        return np.asarray(self.lower + self.size * (self._every + 0.5))

    def draw(self, rng: np.random.Generator) -> Array:
        """(cells, 3) [m] one random point in each cell."""
        return np.asarray(self.lower + self.size * (self._every + rng.uniform(size=(len(self), 3))))

    @property
    def _every(self) -> Index:
        return np.indices(self.counts).reshape(3, -1).T

    def _corner(self, cell: int) -> Array:
        return np.array(np.unravel_index(cell, self.counts), dtype=np.float64)


def cells(box: ArrayLike, counts: Sequence[int]) -> Cells:
    """A box, its lower and upper corner (2, 3) [m] in the base frame, cut into cells along x, y and z."""
    ends = np.asarray(box, dtype=np.float64)
    faults = []
    if ends.shape != (2, 3) or not (np.isfinite(ends).all() and (ends[1] > ends[0]).all()):
        faults.append(Fault("box", f"{ends.tolist()} is none", "give its lower and its upper corner [m]"))
    if len(counts) != 3 or any(int(count) != count or count < 1 for count in counts):
        faults.append(Fault("counts", f"{list(counts)} are none", "three whole numbers from 1: x, y, z"))
    if faults:
        raise InputError(faults)
    nx, ny, nz = (int(count) for count in counts)
    return Cells(ends[0], (ends[1] - ends[0]) / (nx, ny, nz), (nx, ny, nz))


def _spans(low: Array, high: Array) -> str:
    ends = zip("xyz", low, high, strict=True)
    return ", ".join(f"{axis} {1e3 * a:.0f} … {1e3 * b:.0f}" for axis, a, b in ends) + " mm"
