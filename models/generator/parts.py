"""The parts that robots are made of: drums, slabs, bodies. Lengths in mm.

Everything is a loft of rings. Parts are drawn in the base frame at q = 0, with the help of a
`Triad`: an origin and the directions along an arm, to its side, and up from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .design import Design
from .mesh import Array, Mesh, Shape, loft

# Rounded edges: inset and depth, as parts of the edge's radius. The large faces beside it decide the
# normals at its two rings, so one step is shaded as a round.
ROUND = ((1.0, 0.0), (0.0, 1.0))


def circle(n: int) -> Array:
    """(n, 2) points of the unit circle, rounded so that every machine has the same."""
    angles = 2 * np.pi * (np.arange(n) + 0.5) / n
    return np.round(np.column_stack([np.cos(angles), np.sin(angles)]), 9)


Section = tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class Triad:
    """Where a part is drawn: origin [mm] and unit vectors along (a), to the side (s), up (n)."""

    origin: ArrayLike = (0.0, 0.0, 0.0)
    a: ArrayLike = (1.0, 0.0, 0.0)
    s: ArrayLike = (0.0, 1.0, 0.0)
    n: ArrayLike = (0.0, 0.0, 1.0)

    @property
    def axes(self) -> Array:
        return np.array([self.a, self.s, self.n], dtype=float)

    def at(self, *place: float) -> Array:
        """The point at (along, side, up) in the base frame."""
        return np.asarray(self.origin, dtype=float) + np.array(place) @ self.axes

    def moved(self, *place: float) -> Triad:
        return Triad(self.at(*place), self.a, self.s, self.n)

    def turned(self, profile: Sequence[tuple[float, float]], axis: str = "n", sides: int = 28) -> Mesh:
        """A turned part about an axis through the origin; `profile` is (place on the axis, radius)."""
        k = "asn".index(axis)
        u, v, w = (self.axes[(k + i) % 3] for i in (1, 2, 3))
        c = circle(sides)
        spokes = c[:, :1] * u + c[:, 1:] * v
        return loft([self.at(0, 0, 0) + z * w + r * spokes for z, r in profile])

    def drum(
        self,
        axis: str,
        span: tuple[float, float],
        radius: float,
        edge: float = 0.0,
        end: float | None = None,
        sides: int = 28,
    ) -> Mesh:
        """A cylinder about an axis through the origin with rounded edges; `end`: radius at the far end."""
        (low, high), last = span, radius if end is None else end
        profile = [(low, radius), (high, last)]
        if edge > 0:
            profile = [(low + d * edge, radius - i * edge) for i, d in ROUND]
            profile += [(high - d * edge, last - i * edge) for i, d in reversed(ROUND)]
        return self.turned(profile, axis, sides)

    def slab(
        self,
        circles: Sequence[tuple[float, float, float]],
        span: tuple[float, float],
        edge: float,
        axis: str = "s",
        sides: int = 32,
    ) -> Mesh:
        """Convex hull of circles (two places across the axis, radius), thick from low to high.

        Places across are (along, up) for axis s, (along, side) for n, (side, up) for a.
        """
        k = "asn".index(axis)
        first, second = [i for i in range(3) if i != k]
        u, v, w = self.axes[first], self.axes[second], self.axes[k]
        directions = circle(sides)
        centres, radii = np.array([c[:2] for c in circles]), np.array([c[2] for c in circles])
        far = directions[:, :1] * centres[:, 0] + directions[:, 1:] * centres[:, 1] + radii
        best = np.argmax(np.round(far, 6), axis=1)

        def ring(inset: float, along: float) -> Array:
            flat = centres[best] + (radii[best] - inset)[:, None] * directions
            return self.at(0, 0, 0) + flat[:, :1] * u + flat[:, 1:] * v + along * w

        low, high = span
        rings = [ring(i * edge, low + d * edge) for i, d in ROUND]
        rings += [ring(i * edge, high - d * edge) for i, d in reversed(ROUND)]
        return loft(rings)

    def body(
        self,
        sections: Sequence[Section],
        edge: float = 0.0,
        axis: str = "a",
        sides: int = 28,
    ) -> Mesh:
        """A tapered body along an axis through sections with rounded ends.

        A section: (place on the axis, shift across twice, half-width across twice, squareness);
        across is (side, up) for axis a, (along, side) for n, (along, up) for s. Squareness 2 is an
        ellipse, 4 and more a rounded rectangle.
        """
        k = "asn".index(axis)
        first, second = [i for i in range(3) if i != k]
        u, v, w = self.axes[first], self.axes[second], self.axes[k]
        c = circle(sides)
        if edge > 0:
            head, tail = sections[0], sections[-1]
            way = 1.0 if tail[0] > head[0] else -1.0
            ends = [_shrunk(head, i * edge, way * d * edge) for i, d in ROUND]
            others = [_shrunk(tail, i * edge, -way * d * edge) for i, d in reversed(ROUND)]
            sections = [*ends, *sections[1:-1], *others]
        rings = []
        for place, p, q, half_u, half_v, squareness in sections:
            shape = np.round(np.sign(c) * np.abs(c) ** (2 / squareness), 9)
            flat = np.array([p, q]) + np.array([half_u, half_v]) * shape
            rings.append(self.at(0, 0, 0) + place * w + flat[:, :1] * u + flat[:, 1:] * v)
        return loft(rings)


def _shrunk(section: Section, inset: float, shift: float) -> Section:
    place, p, q, half_u, half_v, squareness = section
    return (place + shift, p, q, half_u - inset, half_v - inset, squareness)


def box(
    t: Triad, a: tuple[float, float], s: tuple[float, float], n: tuple[float, float], edge: float
) -> Mesh:
    """A box with rounded edges between places along, to the side and up."""
    (a0, a1), (s0, s1) = a, s
    corners = [(x, y, edge) for x in (a0 + edge, a1 - edge) for y in (s0 + edge, s1 - edge)]
    return t.slab(corners, n, min(edge, 0.49 * (n[1] - n[0])), axis="n", sides=20)


def in_link_frames(design: Design, drawn: Mapping[str, Shape], X_BD: Array | None = None) -> dict[str, Shape]:
    """Shapes drawn in one frame D (base, unless X_BD [mm] is given), each in its own link's frame."""
    X = np.eye(4) if X_BD is None else X_BD
    shapes = {}
    for link, shape in drawn.items():
        X_BL = np.eye(4) if link == "base_link" else design.link_frames()[int(link.split("_")[1]) - 1].copy()
        X_BL[:3, 3] *= 1000
        X_LD = np.linalg.inv(X_BL) @ X
        shapes[link] = [(paint, mesh.moved(X_LD[:3, :3], X_LD[:3, 3])) for paint, mesh in shape]
    return shapes
