"""Where a fitted robot's base is: nothing that moves with the arm tells it from how axis 1 stands in it.

Only gravity does, faintly: what a fit makes of that is how far the base is from level, and no error of the
robot. Unless the base was measured, it is where axis 1 stands in it as the model says.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import RX, Arm, Array
from ..robot.rotations import from_xyz


@dataclass(frozen=True)
class OwnBase:
    """Corrections geometry (S, 6) [m, rad] and gravity (3,) [m/s²] of an arm in the base in which it is kept;
    R (3, 3), t (3,) [m]: that base in the one of the fit. measured: the campaign says where it is."""

    geometry: Array
    gravity: Array
    R: Array
    t: Array
    measured: bool

    def seen(self, R: Array, t: Array) -> tuple[Array, Array]:
        """Frames R (..., 3, 3), t (..., 3) [m] from the fit's base to the instrument, from this base."""
        return R @ self.R, t + R @ self.t

    def arm(self, arm: Arm) -> Arm:
        """The arm, in this base."""
        return replace(arm, geometry=self.geometry, gravity=self.gravity)


def own_base(problem: Problem, geometry: Array) -> OwnBase:
    """The base in which a robot with the fitted corrections geometry (S, 6) is kept."""
    arm = problem.arm
    if problem.base_measured:
        return OwnBase(geometry, arm.gravity, np.eye(3), np.zeros(3), measured=True)
    stated = arm.geometry[1]
    (R, t), (R_stated, t_stated) = (_first(problem, g) for g in (geometry[1], stated))
    turn = R @ R_stated.T
    kept = geometry.copy()
    kept[1] = stated
    return OwnBase(kept, turn.T @ arm.gravity, turn, t - turn @ t_stated, measured=False)


def _first(problem: Problem, g: Array) -> tuple[Array, Array]:
    """Rotation (3, 3) and place (3,) [m] of axis 1 in the base, with its corrections g (6,)."""
    R, p = problem.arm.R[1], problem.arm.p[1]
    return R @ from_xyz(g[None, RX:])[0], p + R @ g[:RX]
