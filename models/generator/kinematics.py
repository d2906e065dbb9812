"""Joint axes of a robot at q = 0, from a Denavit–Hartenberg table or stated directly.

Lengths in m, angles in degrees as printed in data sheets. A `Chain` is what every robot is
brought to: axis points and directions in the base frame at q = 0, and the flange pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.robot.rotations import skew

Array = NDArray[np.float64]
Row = tuple[float, float, float, float]


@dataclass(frozen=True)
class Table:
    """Denavit–Hartenberg rows in mm and degrees.

    standard: (a, alpha, d, theta0), T_i = Rz(q + theta0) Tz(d) Tx(a) Rx(alpha)
    modified: (alpha, a, d, theta0) with alpha, a of the row before,
              T_i = Rx(alpha) Tx(a) Rz(q + theta0) Tz(d)
    `mount` is one fixed standard row in front of joint 1.
    """

    kind: Literal["standard", "modified"]
    rows: Sequence[Row]
    mount: Row | None = None

    def frames(self, q: ArrayLike | None = None) -> list[Array]:
        """Poses X_BF of frames 0..n in the base frame, each (4, 4); `q`: (n,) [rad]."""
        angles = np.zeros(len(self.rows)) if q is None else np.asarray(q, dtype=float)
        frames = [np.eye(4) if self.mount is None else _standard(self.mount, 0.0)]
        step = _standard if self.kind == "standard" else _modified
        for row, angle in zip(self.rows, angles, strict=True):
            frames.append(frames[-1] @ step(row, angle))
        return frames


@dataclass(frozen=True)
class Axis:
    """One joint at q = 0: a point on its axis and its direction, in the base frame [m]."""

    point: Array
    direction: Array
    kind: Literal["revolute", "prismatic"] = "revolute"


@dataclass(frozen=True)
class Chain:
    """Axes of a robot and its flange pose X_BF (4, 4) at q = 0."""

    axes: tuple[Axis, ...]
    flange: Array

    def motions(self, q: ArrayLike) -> list[Array]:
        """Displacement of every link from where it is at q = 0: (4, 4) in the base frame."""
        moved, motions = np.eye(4), []
        for axis, value in zip(self.axes, np.asarray(q, dtype=float), strict=True):
            moved = moved @ _displacement(axis, value)
            motions.append(moved)
        return motions


def chain_of(table: Table) -> Chain:
    """The chain of a table: joint i turns about z of frame i-1 (standard) or i (modified)."""
    frames = table.frames()
    carriers = frames[:-1] if table.kind == "standard" else frames[1:]
    return Chain(tuple(Axis(X[:3, 3], X[:3, 2]) for X in carriers), frames[-1])


def chain_along(axes: Sequence[tuple[str, ArrayLike, ArrayLike]], flange: Array) -> Chain:
    """A chain from (kind, point in mm, direction) per joint and the flange pose."""
    made = tuple(
        Axis(np.asarray(p, dtype=float) / 1000, np.asarray(d, dtype=float), kind)  # type: ignore[arg-type]
        for kind, p, d in axes
    )
    return Chain(made, flange)


def rotation_x(degrees: float) -> Array:
    c, s = _cos_sin(np.radians(degrees))
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rotation_y(degrees: float) -> Array:
    c, s = _cos_sin(np.radians(degrees))
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rotation_z(degrees: float) -> Array:
    c, s = _cos_sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def pose(rotation: Array, mm: ArrayLike) -> Array:
    """(4, 4) from a rotation and an origin in mm."""
    X = np.eye(4)
    X[:3, :3] = rotation
    X[:3, 3] = np.asarray(mm, dtype=float) / 1000
    return X


def _cos_sin(angle: float) -> tuple[float, float]:
    return float(np.cos(angle)), float(np.sin(angle))


def _standard(row: Row, q: float) -> Array:
    a, alpha, d, theta0 = row
    return pose(rotation_z(theta0 + np.degrees(q)), (0, 0, d)) @ pose(rotation_x(alpha), (a, 0, 0))


def _modified(row: Row, q: float) -> Array:
    alpha, a, d, theta0 = row
    return pose(rotation_x(alpha), (a, 0, 0)) @ pose(rotation_z(theta0 + np.degrees(q)), (0, 0, d))


def _displacement(axis: Axis, value: float) -> Array:
    X = np.eye(4)
    if axis.kind == "prismatic":
        X[:3, 3] = value * axis.direction
        return X
    K = skew(axis.direction)
    X[:3, :3] += np.sin(value) * K + (1 - np.cos(value)) * K @ K
    X[:3, 3] = axis.point - X[:3, :3] @ axis.point
    return X
