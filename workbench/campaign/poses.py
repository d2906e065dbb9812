"""What the robot was told, pose by pose: one object for all columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
MIXED = 1e4  # times a pose's place along a line: its fraction is as good as drawn at random
HELD = 1e-3  # rad or m: by less a joint's own error does not change

IntArray = NDArray[np.int64]
Column = Array | IntArray | tuple[str, ...] | None


@dataclass(frozen=True, eq=False)
class Poses:
    """N poses of a robot with n joints. A new column is a field here and a column of the table.

    ids           N names
    q             (N, n) commanded joints [rad, m]
    payload       (N,) index into the campaign's payload names; 0 is the tool only
    wrench        (N, 6) fx fy fz mx my mz [N, N·m] on the robot at the flange origin, base frame
    setup         (N,) index into the campaign's set-ups
    side          (N, n) sign of the last motion, -1 0 +1 (0: none or not known)
    time          (N,) [s], temperature (N,) [°C], torque (N, n) [N·m, N], readback (N, n) [rad, m]

    The last five are None when not given at all; NaN where a cell is empty.
    """

    ids: tuple[str, ...]
    q: Array
    payload: IntArray
    wrench: Array
    setup: IntArray
    side: Array | None = None
    time: Array | None = None
    temperature: Array | None = None
    torque: Array | None = None
    readback: Array | None = None

    def __len__(self) -> int:
        return len(self.ids)

    def columns(self) -> dict[str, Column]:
        """All columns by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def some(self, chosen: IntArray) -> Poses:
        """Only these poses, in this order."""
        return replace(self, **{name: _some(column, chosen) for name, column in self.columns().items()})  # type: ignore[arg-type]

    @property
    def positions(self) -> IntArray:
        """(N,) number of the joint position within its set-up: equal for its loads and repeats."""
        return np.asarray(np.unique(self._places, axis=0, return_inverse=True)[1].ravel(), dtype=np.int64)

    @property
    def by_setup(self) -> list[IntArray]:
        """Numbers of the poses of each set-up."""
        return [np.flatnonzero(self.setup == k) for k in np.unique(self.setup)]

    def in_setup_of(self, pose: int) -> IntArray:
        """Numbers of the poses of the set-up of one."""
        return np.flatnonzero(self.setup == self.setup[pose])

    @property
    def runs(self) -> IntArray:
        """(N,) number of the run of poses on end in which more than half of the joints that move are held."""
        moving = np.ptp(self.q, axis=0) > HELD
        held = (np.abs(np.diff(self.q[:, moving], axis=0)) < HELD).sum(axis=1)
        return np.concatenate([np.zeros(1, np.int64), np.cumsum(2 * held <= moving.sum())])

    def drawn(self, seed: int = 0) -> Array:
        """(N,) a number from 0 to 1 drawn at random for each joint position within its set-up: equal for its
        loads and repeats, and the same whatever other poses there are."""
        way = np.random.default_rng(seed).normal(size=self._places.shape[1])
        return np.asarray(np.mod(MIXED * (self._places * way).sum(axis=1), 1.0))

    @property
    def _places(self) -> Array:
        """(N, n + 1) joints and set-up."""
        return np.column_stack([np.round(self.q, 9), self.setup])


def join_poses(parts: Sequence[Poses]) -> Poses:
    """One after the other. A column that some do not have is NaN there, sides 0, readback the command."""
    lengths = [len(part) for part in parts]
    out: dict[str, Column] = {"ids": tuple(name for part in parts for name in part.ids)}
    for field in fields(Poses)[1:]:
        columns = [getattr(part, field.name) for part in parts]
        if all(column is None for column in columns):
            out[field.name] = None
            continue
        shape = next(column.shape[1:] for column in columns if column is not None)
        empty = 0.0 if field.name == "side" else np.nan
        out[field.name] = np.concatenate(
            [
                np.full((length, *shape), empty) if column is None else column
                for length, column in zip(lengths, columns, strict=True)
            ]
        )
    return Poses(**out)  # type: ignore[arg-type]


def _some(column: Column, chosen: IntArray) -> Column:
    if isinstance(column, tuple):
        return tuple(column[i] for i in chosen)
    return None if column is None else column[chosen]
