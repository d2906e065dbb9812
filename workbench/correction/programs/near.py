"""Of all numbers that say the same rotation, those nearest to given ones: a corrected target still reads
as the old one does (180 stays 180 and does not become −180)."""

from __future__ import annotations

import numpy as np

from ...robot.kinematics import Array

FULL = 2 * np.pi


def near_zyx(angles: Array, like: Array) -> Array:
    """(3,) angles [rad] of R = Rz Ry Rx, or of Rx Ry Rz, or their other solution, each in the turn of `like`
    (3,)."""
    a, b, c = angles
    both = np.array([angles, [a + np.pi, np.pi - b, c + np.pi]])
    both += FULL * np.round((like - both) / FULL)
    return np.asarray(both[np.argmin(np.abs(both - like).sum(axis=1))])


def near_vector(vector: Array, like: Array) -> Array:
    """(3,) rotation vector [rad] of the same rotation in the turn of `like` (3,)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0:
        return vector
    turns = np.array([vector / angle * (angle + k * FULL) for k in (-1, 0, 1)])
    return np.asarray(turns[np.argmin(np.linalg.norm(turns - like, axis=1))])
