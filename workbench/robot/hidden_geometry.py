"""Corrections of the geometry that no measured point can show: others, the base and the tool do as well."""

from __future__ import annotations

import numpy as np

from .kinematics import TZ, Arm, Array, frames, point_jacobian
from .rotations import body_jacobian

POSES = 16  # at random: what shows in none of these shows nowhere
DEPENDENT = 1e-6  # of a column: what is left of it beside the columns before it


def hidden_shifts(arm: Arm) -> frozenset[int]:
    """Columns 6 · slot + component of shifts that the base, the tool on the flange and the corrections before
    them make as well, in any pose of the rigid arm (base parameters, chosen by QR: Gautier 1991)."""
    rng = np.random.default_rng(0)
    where = frames(arm, rng.uniform(-np.pi, np.pi, (POSES, arm.n)))
    points = where.points(rng.uniform(-0.3, 0.3, (3, 3)), [arm.slots - 1] * 3)
    on = [arm.slots - 1] * 3
    G = point_jacobian(where.geometry_axes, where.geometry_origin, points, on)[..., 6 : 6 * (arm.n + 1)]
    base = body_jacobian(points - points.mean(axis=(0, 1)))
    tool = np.einsum("nij,ntjk->ntik", where.R[-1], _about_flange(where.R[-1], where.p[-1], points))
    columns = np.concatenate([base, tool, G], axis=3).reshape(-1, 12 + G.shape[3])
    size = np.linalg.norm(columns, axis=0)
    left = np.abs(np.diag(np.linalg.qr(columns / size, mode="r")))[12:]
    shift = np.arange(6, 6 * (arm.n + 1)) % 6 <= TZ
    return frozenset((6 + np.flatnonzero(shift & (left < DEPENDENT))).tolist())


def _about_flange(R: Array, p: Array, points: Array) -> Array:
    """(N, T, 3, 6) motion of points (N, T, 3) on the flange's axes, by its shift and turn."""
    return body_jacobian(np.einsum("nij,nti->ntj", R, points - p[:, None]))
