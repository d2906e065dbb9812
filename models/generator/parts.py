"""The parts that robots are made of: drums, plates, limbs, motors, feet. Lengths in mm.

Everything is a loft of rings. A part is placed by a point and directions in the base frame at
q = 0; `place.links` moves it into its link's frame.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from .mesh import Array, Mesh, loft

# Quarter-round edges: inset and depth, as parts of the edge's radius.
ROUND = ((1.0, 0.0), (0.62, 0.08), (0.29, 0.29), (0.08, 0.62), (0.0, 1.0))


def circle(n: int) -> Array:
    """(n, 2) points of the unit circle, rounded so that every machine has the same."""
    angles = 2 * np.pi * (np.arange(n) + 0.5) / n
    return np.round(np.column_stack([np.cos(angles), np.sin(angles)]), 9)


def across(axis: ArrayLike) -> tuple[Array, Array, Array]:
    """Two directions u, v across an axis, and the axis: a right-handed set."""
    w = np.asarray(axis, dtype=float)
    w = w / np.sqrt(np.sum(w * w))
    helper = np.eye(3)[int(np.argmin(np.abs(w) + np.array([2e-3, 1e-3, 0.0])))]
    u = np.cross(helper, w)
    u = u / np.sqrt(np.sum(u * u))
    return u, np.cross(w, u), w


def lathe(origin: ArrayLike, axis: ArrayLike, profile: Sequence[tuple[float, float]], n: int = 32) -> Mesh:
    """A turned part: `profile` is (distance along the axis, radius)."""
    u, v, w = across(axis)
    c = circle(n)
    spokes = c[:, :1] * u + c[:, 1:] * v
    return loft([np.asarray(origin) + z * w + r * spokes for z, r in profile])


def drum(
    start: ArrayLike, end: ArrayLike, radius: float, edge: float = 0.0, n: int = 32, taper: float = 1.0
) -> Mesh:
    """A cylinder (a cone with `taper` != 1) from `start` to `end` with rounded edges."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.sqrt(np.sum((b - a) ** 2)))
    profile = [(0.0, radius), (length, radius * taper)]
    if edge > 0:
        profile = [(d * edge, radius - i * edge) for i, d in ROUND]
        profile += [(length - d * edge, radius * taper - i * edge) for i, d in reversed(ROUND)]
    return lathe(a, b - a, profile, n)


def plate(
    circles: Sequence[tuple[ArrayLike, float]],
    axis: ArrayLike,
    span: tuple[float, float],
    edge: float,
    n: int = 48,
) -> Mesh:
    """The convex hull of circles (centre, radius) in the plane across `axis`, as thick as `span`.

    `span` is measured along the axis from the base origin; the centres' own places along it are ignored.
    """
    u, v, w = across(axis)
    directions = circle(n)
    centres = np.array([[np.dot(c, u), np.dot(c, v)] for c, _ in circles])
    radii = np.array([r for _, r in circles])
    best = np.argmax(np.round(directions @ centres.T + radii, 6), axis=1)

    def ring(inset: float, along: float) -> Array:
        flat = centres[best] + (radii[best] - inset)[:, None] * directions
        return flat[:, :1] * u + flat[:, 1:] * v + along * w

    low, high = span
    rings = [ring(i * edge, low + d * edge) for i, d in ROUND]
    rings += [ring(i * edge, high - d * edge) for i, d in reversed(ROUND)]
    return loft(rings)


def limb(
    sections: Sequence[tuple[ArrayLike, float, float, float]], u: ArrayLike, v: ArrayLike, n: int = 32
) -> Mesh:
    """A tapered body through sections (centre, half-width along u, along v, squareness).

    Squareness 2 is an ellipse, 4 and more a rounded rectangle.
    """
    e, f = np.asarray(u, dtype=float), np.asarray(v, dtype=float)
    c = circle(n)
    rings = []
    for centre, a, b, squareness in sections:
        shape = np.round(np.sign(c) * np.abs(c) ** (2 / squareness), 9)
        rings.append(np.asarray(centre) + a * shape[:, :1] * e + b * shape[:, 1:] * f)
    return loft(rings)
