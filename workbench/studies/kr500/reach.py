"""Joints of the KR 500 for given flange poses, in closed form: elbow up, wrist bent down."""

from __future__ import annotations

import numpy as np

from workbench import Array, Fault, InputError, Robot

WRIST = 0.29  # m, from the flange
SHOULDER = 0.5, 1.045  # m, of joint 2 from axis 1 and above the floor
ARM, FOREARM, CRANK = 1.3, float(np.hypot(1.025, 0.055)), float(np.arctan2(0.055, 1.025))  # m, m, rad
REACH = 0.73, 2.28  # m, from the shoulder to the wrist: elbow nearly folded, arm nearly straight


def rises(wrist: Array) -> tuple[Array, Array, Array]:
    """Of wrists (..., 3) [m]: elevations [rad] of the upper arm and of the forearm's axis, and whether they
    are within reach, and before the shoulder."""
    out = np.hypot(wrist[..., 0], wrist[..., 1]) - SHOULDER[0]
    high = wrist[..., 2] - SHOULDER[1]
    straight = np.hypot(out, high)
    far = np.clip(straight, *REACH)
    at_shoulder, at_wrist = (
        np.arccos((one**2 + far**2 - other**2) / (2 * one * far))
        for one, other in ((ARM, FOREARM), (FOREARM, ARM))
    )
    rise = np.arctan2(high, out)
    return rise + at_shoulder, rise - at_wrist + CRANK, (far == straight) & (out > 0.25)


def joints(robot: Robot, place: Array, R: Array) -> Array:
    """(M, 6) joints of the flange at place (M, 3) [m] with rotation R (M, 3, 3). Raises `InputError` where it
    is out of reach or out of a joint's range."""
    wrist = place - WRIST * R[:, :, 2]
    upper, fore, possible = rises(wrist)
    q1 = np.arctan2(wrist[:, 1], wrist[:, 0])
    c, s, up, ahead = np.cos(q1), np.sin(q1), np.sin(fore), np.cos(fore)
    zero = np.zeros(len(q1))
    forearm = np.array([[ahead * c, ahead * s, up], [-s, c, zero], [-up * c, -up * s, ahead]])
    hand = R @ np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # joint 6 along x
    W = np.einsum("icm,mcj->mij", forearm, hand)
    q4, q5 = np.arctan2(W[:, 1, 0], -W[:, 2, 0]), np.arccos(np.clip(W[:, 0, 0], -1.0, 1.0))
    q6 = np.arctan2(W[:, 0, 1], W[:, 0, 2]) % (2 * np.pi)  # about half a turn, where the tool hangs
    q = np.column_stack([q1, -upper, upper - fore, q4, q5, q6])
    lower, higher = robot.limits.T
    if not (possible.all() and (q >= lower).all() and (q <= higher).all()):
        raise InputError(Fault("box", "is out of reach", "another place, height or tool"))
    return q
