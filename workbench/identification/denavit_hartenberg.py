"""Standard Denavit–Hartenberg rows, and what they change about an arm.

A row is (θ, α, a, d) [rad, rad, m, m], link i being  Rz(θᵢ + qᵢ) Tz(dᵢ) Tx(aᵢ) Rx(αᵢ): θ and d sit at joint
i's own axis, a and α behind it, where joint i + 1 begins. The workbench corrects an arm by one small frame
change per joint (`robot.kinematics`); `corrections` says which ones turn one table into another.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..robot.description import Robot
from ..robot.kinematics import RX, RZ, TZ, Arm, Array, frames
from ..robot.rigid_plant import arrays
from ..robot.rotations import pose, screw, xyz_angles
from .fit import Fit


def chain(rows: Array, q: Array) -> Array:
    """(N, n + 1, 4, 4) poses of the frames 0 (base) to n in the base frame, for joints q: (N, n) [rad]."""
    rows, q = np.asarray(rows, dtype=np.float64), np.asarray(q, dtype=np.float64)
    out = np.tile(np.eye(4), (len(q), len(rows) + 1, 1, 1))
    for i, (theta, alpha, a, d) in enumerate(rows):
        out[:, i + 1] = out[:, i] @ screw("z", theta + q[:, i], d) @ screw("x", alpha, a)
    return out


def corrections(arm: Arm, nominal: Array, practical: Array) -> tuple[Array, Array]:
    """Corrections (S, 6) tx ty tz rx ry rz [m, rad] that turn an arm of rows `nominal` (n, 4) into one of
    rows `practical`, and the last row's a and α: (4, 4) pose of the practical frame n in the flange's place.

    Slot i carries θ and d of row i in its rz and tz, and a and α of row i − 1. The last row's a and α come
    behind the last joint, where no correction sits: they move the targets. Raises ValueError when the
    arm's axes are not those of `nominal`.
    """
    turned = _turned(arm, nominal)
    out = np.zeros((arm.slots, 6))
    for i in range(arm.n):
        X = _behind(nominal[i - 1], practical[i - 1], turned[i]) if i else np.eye(4)
        theta, _, _, d = practical[i] - nominal[i]
        X = X @ screw("z", theta, d)
        out[i + 1, :RX] = X[:3, 3]
        out[i + 1, RX:] = xyz_angles(X[None, :3, :3])[0]
    return out, _behind(nominal[-1], practical[-1], turned[-1])


def with_rows(robot: Robot, nominal: Array, practical: Array) -> Robot:
    """The robot with the geometry of rows `practical`, where its URDF has `nominal` (all but the last a, α).

    Raises ValueError as `corrections` does.
    """
    arm = arrays(replace(robot, geometry={}))
    return robot.corrected(corrections(arm, nominal, practical)[0])


def axial_columns(robot: Robot) -> list[int]:
    """The columns of `fit`'s geometry that are each joint's d and θ."""
    return [6 * slot + part for slot in range(1, len(robot.joints) + 1) for part in (TZ, RZ)]


def fitted_rows(found: Fit, rows: Array) -> tuple[Array, Array]:
    """The rows (n, 4) after a fit of `axial_columns` that started from `rows`, and the covariance (2 n, 2 n)
    of their d and θ in the order d₁ θ₁ d₂ θ₂ ... [m, rad]."""
    moved = found.state.geometry - found.model.problem.arm.geometry
    out = np.array(rows, dtype=np.float64)
    out[:, 0] += moved[1:-1, RZ]
    out[:, 3] += moved[1:-1, TZ]
    part = found.columns.geometry_slice
    return out, found.covariance[part, part]


def _turned(arm: Arm, nominal: Array) -> Array:
    """(n + 1, 4, 4) pose of each slot (of the joints, then the flange) in its DH frame, joints at zero."""
    here = frames(replace(arm, geometry=np.zeros_like(arm.geometry)), np.zeros((1, arm.n)))
    out = np.linalg.inv(chain(nominal, np.zeros((1, arm.n)))[0]) @ pose(here.p[1:, 0], here.R[1:, 0])
    off = np.abs(out[:-1, :3, 2] - [0, 0, 1]).max(axis=1) + np.abs(out[:-1, :2, 3]).max(axis=1)
    if off.max() > 1e-6:
        first = arm.names[int(np.argmax(off > 1e-6))]
        raise ValueError(f"{first}: the arm's axis is not that of the DH rows")
    return out


def _behind(nominal: Array, practical: Array, turned: Array) -> Array:
    """(4, 4) change of a frame behind a row's a and α, on the axes of the slot that stands there."""
    before, after = screw("x", nominal[1], nominal[2]), screw("x", practical[1], practical[2])
    return np.asarray(np.linalg.inv(turned) @ np.linalg.inv(before) @ after @ turned)
