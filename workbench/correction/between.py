"""What is left between the samples of a corrected path, which the controller joins by straight lines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..robot import rotations
from ..robot.kinematics import Array
from .inverse import newton
from .solve import settle
from .trajectory import Trajectory

LONG, WIDE = 5e-3, np.radians(1)  # m, rad: legs that are shorter say nothing that their ends do not


def left_between(trajectory: Trajectory, q: Array, X: Array, direction: Array | None) -> Array:
    """(N − 1,) distance [m] of the extended robot's tool from half the way between neighbouring samples, were
    the commanded tool poses X (N, 4, 4), of joints q (N, n), joined by straight lines, the turn in step;
    0 of short legs, NaN of those that the arm cannot run so."""
    wanted = trajectory.X
    way = np.linalg.norm(np.diff(wanted[:, :3, 3], axis=0), axis=1)
    turn = rotations.angle_between(wanted[:-1, :3, :3], wanted[1:, :3, :3])
    legs = np.flatnonzero((way > LONG) | (turn > WIDE))
    out = np.zeros(len(wanted) - 1)
    if not len(legs):
        return out
    between = rotations.straight(X[legs], X[legs + 1], 0.5)
    joints, there = newton(trajectory.nominal, trajectory.tip, between, 0.5 * (q[legs] + q[legs + 1]))
    extended, side = trajectory.extended, None if direction is None else direction[legs + 1]
    here = replace(
        trajectory,
        X=rotations.straight(wanted[legs], wanted[legs + 1], 0.5),
        q=joints,
        extended=replace(extended, problem=extended.at(joints, side, legs + 1)),
    )
    rest = settle(here, joints, side)
    left = np.linalg.norm(rest.error[:, :3], axis=1)
    out[legs] = np.where(there & rest.there, left, np.nan)
    return out
