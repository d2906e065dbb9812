"""Which of its postures a six-axis arm stands in: what FANUC's CONFIG and ABB's confdata say of a pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...robot.convention import Convention
from ...robot.description import Robot
from ...robot.kinematics import Array, frames
from ...robot.rigid_plant import arrays

FULL = 2 * np.pi


def posture(robot: Robot, convention: Convention, q: Array) -> NDArray[np.bool_] | None:
    """(N, 3) flags of poses (N, 6): wrist centre in front of axis 1, elbow up, joint 5 shown positive.

    q: the URDF's joints. None for an arm that has not six turning joints. In front is where a positive turn
    about axis 2 leans an upright arm; the elbow is up when the forearm leans from the upper arm to that side.
    """
    if len(robot.joints) != 6 or any(robot.sliding):
        return None
    arm = arrays(robot)
    where = frames(arm.with_geometry(np.zeros_like(arm.geometry)), q)
    signs = np.sign(convention.A[1, 1] or 1.0)
    axis2 = signs * where.axes[:, 2, arm.axial[1] % 6]
    up = where.axes[:, 1, arm.axial[0] % 6]
    up = up * np.where(up[:, 2:] < 0, -1.0, 1.0)
    shoulder, elbow, wrist = (where.origin[:, slot] for slot in (2, 3, 5))
    reach = np.einsum("ij,ij->i", wrist - where.origin[:, 1], np.cross(axis2, up))
    fold = np.einsum("ij,ij->i", np.cross(elbow - shoulder, wrist - elbow), axis2)
    fifth = np.sin(convention.shown(q)[:, 4])
    return np.stack([reach >= 0, fold >= 0, fifth >= 0], axis=1)


def turn_numbers(angles: Array) -> NDArray[np.int64]:
    """FANUC's turn numbers of joints [rad]: 0 within ±180°, 1 from 180° to 540°, −1 from −540° to −180°."""
    return np.asarray(np.floor((angles + np.pi) / FULL), dtype=np.int64)
