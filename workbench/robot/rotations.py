"""Rotations and rigid motions: as matrices, and in the controllers' own numbers, exact also at gimbal lock.

Rz(a) Ry(b) Rx(c): KUKA A B C, Fanuc R P W (the same turns, fixed axes x y z read backwards).
Rx(a) Ry(b) Rz(c): Stäubli rx ry rz, the other order.
Quaternions w x y z: ABB. Rotation vectors: Universal Robots.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def zyx_angles(R: Array) -> Array:
    """(N, 3) a, b, c [rad] with R = Rz(a) Ry(b) Rx(c); |b| ≤ 90°.

    c is found after a is taken out of R, not from R itself: so where a and c are not unique (b = ±90°)
    they still make the same rotation, however a came out.
    """
    a = np.arctan2(R[:, 1, 0], R[:, 0, 0])
    sin, cos = np.sin(a), np.cos(a)
    b = np.arctan2(-R[:, 2, 0], cos * R[:, 0, 0] + sin * R[:, 1, 0])
    c = np.arctan2(sin * R[:, 0, 2] - cos * R[:, 1, 2], cos * R[:, 1, 1] - sin * R[:, 0, 1])
    return np.stack([a, b, c], axis=1)


def from_zyx(angles: Array) -> Array:
    """(N, 3, 3) Rz(a) Ry(b) Rx(c) from (N, 3) [rad]."""
    return np.asarray(Rotation.from_euler("ZYX", angles).as_matrix())


def xyz_angles(R: Array) -> Array:
    """(N, 3) a, b, c [rad] with R = Rx(a) Ry(b) Rz(c): the transpose is Rz(−c) Ry(−b) Rx(−a)."""
    return -zyx_angles(np.swapaxes(R, 1, 2))[:, ::-1]


def from_xyz(angles: Array) -> Array:
    """(N, 3, 3) Rx(a) Ry(b) Rz(c) from (N, 3) [rad]."""
    return np.asarray(Rotation.from_euler("XYZ", angles).as_matrix())


def quaternions(R: Array) -> Array:
    """(N, 4) unit quaternions w x y z: the first with w ≥ 0, each next on the side of the one before."""
    quaternion = Rotation.from_matrix(R).as_quat(canonical=True)[:, [3, 0, 1, 2]]
    turned_over = np.einsum("ni,ni->n", quaternion[1:], quaternion[:-1]) < 0
    sign = np.cumprod(np.concatenate([[1.0], np.where(turned_over, -1.0, 1.0)]))
    return np.asarray(quaternion * sign[:, None])


def from_quaternions(quaternion: Array) -> Array:
    """(N, 3, 3) from (N, 4) w x y z of any length but zero."""
    return np.asarray(Rotation.from_quat(quaternion[:, [1, 2, 3, 0]]).as_matrix())


def vectors(R: Array) -> Array:
    """(N, 3) rotation vectors [rad], axis times angle, length ≤ π (for small turns faster than SciPy's)."""
    v = 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)
    sine, cosine = np.sqrt(np.einsum("ki,ki->k", v, v)), 0.5 * (np.einsum("kii->k", R) - 1)
    out = v * np.where(sine > 1e-6, np.arctan2(sine, cosine) / np.maximum(sine, 1e-6), 1.0)[:, None]
    half = (sine <= 1e-3) & (cosine < 0)  # near a half turn v says little of its axis
    if half.any():
        out[half] = Rotation.from_matrix(R[half]).as_rotvec()
    return np.asarray(out)


def from_vectors(vector: Array) -> Array:
    """(N, 3, 3) from (N, 3) rotation vectors [rad], (3, 3) from one (3,)."""
    return np.asarray(Rotation.from_rotvec(vector).as_matrix())


def from_vector(vector: Array) -> Array:
    """(3, 3) from one rotation vector (3,) [rad] by Rodrigues' formula (seven times as fast as SciPy's)."""
    x, y, z = vector.tolist()
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    if angle > 1e-4:
        c, d = math.sin(angle) / angle, (1 - math.cos(angle)) / square
    else:
        c, d = 1 - square / 6, 0.5 - square / 24
    return np.array(
        [
            [1 - d * (y * y + z * z), d * x * y - c * z, d * x * z + c * y],
            [d * x * y + c * z, 1 - d * (x * x + z * z), d * y * z - c * x],
            [d * x * z - c * y, d * y * z + c * x, 1 - d * (x * x + y * y)],
        ]
    )


def rotation_about(axis: str, angle: Array | float) -> Array:
    """(..., 3, 3) turns by `angle` (...) [rad] about the axis "x", "y" or "z"."""
    turn = Rotation.from_euler(axis, np.reshape(angle, (-1, 1))).as_matrix()
    return np.asarray(turn.reshape(*np.shape(angle), 3, 3))


def straight(start: Array, end: Array, share: Array | float) -> Array:
    """(K, 4, 4) poses at shares (K,) of the straight way from start to end, the turn in step. start, end:
    (4, 4) or (K, 4, 4)."""
    a, b, share = start.reshape(-1, 4, 4), end.reshape(-1, 4, 4), np.reshape(share, (-1, 1))
    turn = from_vectors(share * vectors(a[:, :3, :3].transpose(0, 2, 1) @ b[:, :3, :3]))
    return pose(a[:, :3, 3] + share * (b[:, :3, 3] - a[:, :3, 3]), a[:, :3, :3] @ turn)


def angle_between(A: Array, B: Array) -> Array:
    """(N,) angle [rad] of the rotation from A to B, each (N, 3, 3)."""
    return np.asarray((Rotation.from_matrix(A).inv() * Rotation.from_matrix(B)).magnitude())


def nearest_turn(a: Array, b: Array) -> Array:
    """(3, 3) that turns points a (M, 3) about zero onto b as well as any (Kabsch's)."""
    u, _, vt = np.linalg.svd(b.T @ a)
    if np.linalg.det(u @ vt) < 0:
        u[:, 2] *= -1
    return np.asarray(u @ vt)


def cross(a: Array, b: Array) -> Array:
    """Cross product over the last axis with broadcasting (three times as fast as NumPy's)."""
    a, b = np.broadcast_arrays(a, b)
    out = np.empty(a.shape)
    out[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    out[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    out[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return out


def skew(v: Array) -> Array:
    """(..., 3, 3) of vectors (..., 3): skew(v) w = v × w."""
    out = np.zeros((*np.shape(v), 3))
    x, y, z = np.moveaxis(v, -1, 0)
    out[..., 2, 1], out[..., 0, 2], out[..., 1, 0] = x, y, z
    out[..., 1, 2], out[..., 2, 0], out[..., 0, 1] = -x, -y, -z
    return out


def turn_z_to(axis: Array) -> Array:
    """(3, 3) smallest rotation that takes z to the unit vector `axis` (3,): a half turn about x for −z."""
    if axis[2] < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    V = skew(np.cross([0.0, 0.0, 1.0], axis))
    return np.asarray(np.eye(3) + V + V @ V / (1 + axis[2]))


def pose(p: Array, R: Array) -> Array:
    """(..., 4, 4) poses of positions (..., 3) [m] and rotations (..., 3, 3)."""
    X = np.zeros((*np.broadcast_shapes(np.shape(p)[:-1], np.shape(R)[:-2]), 4, 4))
    X[..., :3, :3], X[..., :3, 3], X[..., 3, 3] = R, p, 1.0
    return X


def screw(axis: str, angle: Array | float, shift: float) -> Array:
    """(..., 4, 4) turn by `angle` (...) [rad] about the axis "x", "y" or "z", and shift [m] along it."""
    return pose(shift * np.eye(3)["xyz".index(axis)], rotation_about(axis, angle))


def body_jacobian(arms: Array) -> Array:
    """(..., 3, 6) motion of points per shift (3) and turn (3) of the rigid body that carries them.

    arms: (..., 3) [m] from the pivot of the turn to the points.
    """
    out = np.zeros((*np.shape(arms), 6))
    x, y, z = arms[..., 0], arms[..., 1], arms[..., 2]
    out[..., 0, 0] = out[..., 1, 1] = out[..., 2, 2] = 1.0
    out[..., 0, 4], out[..., 1, 5], out[..., 2, 3] = z, x, y
    out[..., 0, 5], out[..., 1, 3], out[..., 2, 4] = -y, -z, -x
    return out


def tool_pose(X_FT: Array | None) -> Array:
    """(4, 4) pose of the tool in the flange frame; of None the flange's own."""
    return np.eye(4) if X_FT is None else np.asarray(X_FT, dtype=np.float64)
