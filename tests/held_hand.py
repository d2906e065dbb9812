"""Joints of a ur5 whose hand goes where it is told and hardly turns: such poses determine no target."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from workbench.campaign.planned import TARGETS, planned
from workbench.campaign.problem import problem_of
from workbench.robot.description import load_robot
from workbench.robot.kinematics import frames

START = np.array([0.3, -1.2, 1.5, -0.8, 1.2, 0.4])


def held(shift: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """(N, 6) [rad], in degrees with six decimals as files have them, for shifts (N, 3) [m] and turns (N, 3)
    [rad] of the flange from where it starts, both on the base's axes."""
    arm = problem_of(planned(load_robot("ur5"), START[None], targets=TARGETS[:1])).arm
    begin, q, joints = frames(arm, START[None]), START, []
    for place, by in zip(shift, turn, strict=True):

        def off(q, place=place, by=by):
            now = frames(arm, q[None])
            R = Rotation.from_rotvec(by).as_matrix() @ begin.R[-1][0]
            turned = Rotation.from_matrix(now.R[-1][0] @ R.T).as_rotvec()
            return np.concatenate([now.p[-1][0] - begin.p[-1][0] - place, turned])

        q = least_squares(off, q, xtol=1e-14, ftol=1e-14, gtol=1e-14).x
        joints.append(q)
    return np.radians(np.degrees(joints).round(6))
