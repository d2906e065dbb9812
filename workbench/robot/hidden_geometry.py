"""Corrections of the geometry that no measured point can show: others, the base and the tool do as well."""

from __future__ import annotations

import numpy as np

from .kinematics import RX, RY, RZ, TX, TY, TZ, Arm, Array, frames, point_jacobian
from .rotations import body_jacobian

POSES = 16  # at random: what shows in none of these shows nowhere
DEPENDENT = 1e-6  # of a column: what is left of it beside the columns before it
TEN = 10.0  # times as far as itself, m and rad, what stands in for a correction goes at most: farther is none


def hidden_corrections(arm: Arm) -> frozenset[int]:
    """Columns 6 · slot + component of corrections that the base, the tool on the flange and the corrections
    before them make as well, in any pose of the rigid arm (base parameters, chosen by QR: Gautier 1991).

    A joint's own zero comes before its shifts and these before its other turns: so of a link that lies
    otherwise between its two axes, which shows in loads alone, the joints' zeros are what may be off. These
    are never among them, nor are the base's own turns, which gravity shows.
    """
    order = [6 * slot + c for slot in range(1, arm.n + 1) for c in (RZ, TX, TY, TZ, RX, RY)]
    rng = np.random.default_rng(0)
    where = frames(arm, rng.uniform(-np.pi, np.pi, (POSES, arm.n)))
    points = where.points(rng.uniform(-0.3, 0.3, (3, 3)), [arm.slots - 1] * 3)
    on = [arm.slots - 1] * 3
    G = point_jacobian(where.geometry_axes, where.geometry_origin, points, on)[..., order]
    base = body_jacobian(points - points.mean(axis=(0, 1)))
    tool = np.einsum("nij,ntjk->ntik", where.R[-1], _about_flange(where.R[-1], where.p[-1], points))
    columns = np.concatenate([base, tool, G], axis=3).reshape(-1, 12 + G.shape[3])
    size = np.linalg.norm(columns, axis=0)
    left = np.abs(np.diag(np.linalg.qr(columns / size, mode="r")))
    hidden = set[int]()
    for i, column in enumerate(order, start=12):
        turn = column % 6 > TZ
        if left[i] > DEPENDENT or (turn and (column < 12 or column % 6 == RZ)):
            continue
        instead = np.linalg.lstsq(columns[:, :i], columns[:, i], rcond=DEPENDENT)[0]
        if np.abs(instead[12:]).max(initial=0.0) <= TEN:
            hidden.add(column)
    return frozenset(hidden)


def _about_flange(R: Array, p: Array, points: Array) -> Array:
    """(N, T, 3, 6) motion of points (N, T, 3) on the flange's axes, by its shift and turn."""
    return body_jacobian(np.einsum("nij,nti->ntj", R, points - p[:, None]))
