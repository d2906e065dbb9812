"""Circular legs: from a point over a via point to another."""

from __future__ import annotations

import numpy as np

from ...robot.kinematics import Array


def circles(start: Array, via: Array, end: Array) -> tuple[Array, Array, Array, Array]:
    """The circles through three points each, all (N, 3) [m].

    Returns centre (N, 3) [m], radius (N,) [m], sweep (N,) [rad] from start over via to end (0 < sweep < 2π),
    and the unit normal (N, 3) about which it turns. NaN where the three lie on a line.
    """
    a, b = via - start, end - start
    normal = np.cross(a, b)
    square = (normal**2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        to_centre = np.cross((a**2).sum(axis=1)[:, None] * b - (b**2).sum(axis=1)[:, None] * a, normal)
        to_centre /= 2 * np.where(square > 0, square, np.nan)[:, None]
        axis = normal / np.sqrt(square)[:, None]
        centre, radius = start + to_centre, np.linalg.norm(to_centre, axis=1)
    return centre, radius, swept(centre, axis, start, end), axis


def swept(centre: Array, axis: Array, start: Array, points: Array) -> Array:
    """(N,) angle [rad] in 0..2π about `axis` from start to points, seen from centre; all (N, 3) or (3,)."""
    u = start - centre
    v = points - centre
    sine = np.einsum("...i,...i->...", axis, np.cross(u, v))
    return np.asarray(np.arctan2(sine, np.einsum("...i,...i->...", u, v)) % (2 * np.pi))


def chords_and_tangents(X: Array, via: Array | None) -> tuple[Array, Array, Array]:
    """Length (N − 1,) [m] of the legs of N poses (N, 4, 4), and unit directions (N − 1, 3) at their start and
    end. via: (N, 4, 4), NaN where the leg to that point is straight; None: all are."""
    p = X[:, :3, 3]
    way = np.diff(p, axis=0)
    length = np.linalg.norm(way, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        leave = way / length[:, None]
    arrive = leave.copy()
    if via is not None and (bent := np.flatnonzero(np.isfinite(via[1:, 0, 3]))).size:
        centre, radius, sweep, axis = circles(p[bent], via[bent + 1, :3, 3], p[bent + 1])
        length[bent] = radius * sweep
        for place, at in ((leave, p[bent]), (arrive, p[bent + 1])):
            place[bent] = np.cross(axis, at - centre) / radius[:, None]
    return length, leave, arrive
