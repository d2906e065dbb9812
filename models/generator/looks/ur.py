"""The UR arms: tubes between joint housings, each housing with a coloured cap."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ..design import Design
from ..mesh import Array, Mesh, Shape
from ..parts import Triad, in_link_frames
from .paints import BLACK, DARK, SILVER, SKY, STEEL

BIG, SMALL = 58.0, 37.5  # radii of the UR5's housings of joints 1..3 and 4..6, mm


def ur(beside: float, apart: float, size: float = 1.0) -> Callable[[Design], Mapping[str, Shape]]:
    """How to draw a UR arm.

    beside: forearm's plane beside that of axis 5, apart: upper arm's plane beside the forearm's [mm];
    size:   of its housings and tubes, the UR5's are 1.
    """
    return lambda design: _drawn(design, beside / size, apart / size, size)


def _drawn(design: Design, beside: float, apart: float, size: float) -> Mapping[str, Shape]:
    """Drawn as thick as the UR5 on an arm that is smaller by `size`, and enlarged."""
    points = [1000 * axis.point / size for axis in design.chain.axes]
    shoulder, elbow, wrist_1, wrist_2, wrist_3 = points[1:]
    tip = 1000 * design.chain.flange[:3, 3] / size
    plane = float(wrist_2[1])  # where axis 5 stands; the tubes stand beside it
    fore = plane + beside
    upper = fore - apart
    drawn = {
        "base_link": _base(),
        "link_1": _shoulder(shoulder, upper),
        "link_2": _upper_arm(shoulder, elbow, upper, fore),
        "link_3": _forearm(elbow, wrist_1, upper, fore, plane),
        "link_4": _wrist(wrist_2, (fore, plane), (float(wrist_2[2]), float(wrist_3[2]))),
        "link_5": _hand(wrist_3, (float(wrist_2[2]), float(wrist_3[2])), float(tip[1])),
        "link_6": _flange(tip),
    }
    return in_link_frames(design, {link: _enlarged(shape, size) for link, shape in drawn.items()})


def _enlarged(shape: Shape, size: float) -> Shape:
    return [(paint, mesh.moved(size * np.eye(3), np.zeros(3))) for paint, mesh in shape]


def _cap(t: Triad, axis: str, at: float, way: int, radius: float) -> Shape:
    """A coloured cap that closes a housing at `at`, towards `way`; a dark seam under it."""
    seam, thick = 0.07 * radius, 0.42 * radius
    profile = [(0.0, radius), (0.45, radius), (0.8, 0.9 * radius), (0.97, 0.68 * radius), (1.0, 0.5 * radius)]
    dome = t.turned([(at + way * (seam + z * thick), r) for z, r in profile], axis)
    return [(DARK, _ring(t, axis, at, way * seam, 0.965 * radius)), (SKY, dome)]


def _ring(t: Triad, axis: str, at: float, long: float, radius: float) -> Mesh:
    return t.turned([(at, radius), (at + long, radius)], axis)


def _base() -> Shape:
    t = Triad()
    shape: Shape = [
        (SILVER, t.drum("n", (0, 16), 75, 3)),
        (SILVER, t.turned([(16, 66), (24, 62), (34, 60)])),
        (DARK, _ring(t, "n", 34, 5, 57)),
    ]
    for x, y in ((46, 46), (46, -46), (-46, 46), (-46, -46)):
        shape.append((BLACK, t.moved(x, y, 0).drum("n", (12, 17), 5, sides=10)))
    return shape


def _shoulder(shoulder: Array, upper: float) -> Shape:
    t = Triad(shoulder)
    seam = upper + BIG + 4
    return [
        (SILVER, t.turned([(-50, BIG), (-6, BIG), (10, 0.9 * BIG)])),
        (SILVER, t.drum("s", (seam, 46), BIG, 4)),
        *_cap(t, "s", 46, 1, BIG),
    ]


def _upper_arm(shoulder: Array, elbow: Array, upper: float, fore: float) -> Shape:
    t, e = Triad(shoulder), Triad(elbow)
    length = float(elbow[0] - shoulder[0])
    face = 0.5 * (upper + fore)
    at = t.moved(0, upper, 0)
    return [
        (DARK, _ring(t, "s", upper + BIG, 4, 0.965 * BIG)),
        (SILVER, t.drum("s", (upper - 40, upper + BIG), BIG, 4)),
        *_cap(t, "s", upper - 40, -1, BIG),
        (SILVER, at.turned([(-20, 48), (-70, 46), (-82, 42)], "a")),
        (STEEL, at.turned([(-70, 41), (length + 60, 39)], "a")),
        (SILVER, at.turned([(length + 70, 40), (length + 58, 43), (length + 20, 44)], "a")),
        (SILVER, e.drum("s", (upper - 36, face - 2), 0.86 * BIG, 4)),
        *_cap(e, "s", upper - 36, -1, 0.86 * BIG),
        (DARK, _ring(e, "s", face - 2, 4, 0.83 * BIG)),
    ]


def _forearm(elbow: Array, wrist: Array, upper: float, fore: float, plane: float) -> Shape:
    e, w = Triad(elbow), Triad(wrist)
    length = float(wrist[0] - elbow[0])
    face, end = 0.5 * (upper + fore), 0.5 * (fore + plane)
    at = e.moved(0, fore, 0)
    return [
        (SILVER, e.drum("s", (face + 2, fore + 34), 0.86 * BIG, 4)),
        *_cap(e, "s", fore + 34, 1, 0.86 * BIG),
        (SILVER, at.turned([(-20, 40), (-62, 38), (-74, 34)], "a")),
        (STEEL, at.turned([(-62, 33), (length + 48, 30)], "a")),
        (SILVER, at.turned([(length + 58, 31), (length + 46, 34), (length + 10, 35)], "a")),
        (SILVER, w.drum("s", (end + 2, fore + 28), SMALL, 3)),
        *_cap(w, "s", fore + 28, 1, SMALL),
        (DARK, _ring(w, "s", end - 2, 4, 0.96 * SMALL)),
    ]


def _wrist(wrist: Array, y: tuple[float, float], z: tuple[float, float]) -> Shape:
    fore, plane = y
    t = Triad((wrist[0], 0, wrist[2]))
    up = Triad((wrist[0], plane, 0))
    middle = 0.5 * (z[0] + z[1])
    return [
        (SILVER, t.drum("s", (plane - 26, 0.5 * (fore + plane) - 2), SMALL, 3)),
        *_cap(up, "n", z[0] + 40, 1, SMALL),
        (SILVER, up.drum("n", (middle + 2, z[0] + 40), SMALL, 3)),
        (DARK, _ring(up, "n", middle - 2, 4, 0.96 * SMALL)),
    ]


def _hand(wrist: Array, z: tuple[float, float], end: float) -> Shape:
    x, plane, low = wrist
    up = Triad((x, plane, 0))
    t = Triad((x, 0, low))
    middle = 0.5 * (z[0] + z[1])
    return [
        (SILVER, up.drum("n", (low - 26, middle - 2), SMALL, 3)),
        (SILVER, t.drum("s", (end + 36, plane + 40), SMALL, 3)),
        *_cap(t, "s", plane + 40, 1, SMALL),
        (DARK, _ring(t, "s", end + 32, 4, 0.96 * SMALL)),
    ]


def _flange(tip: Array) -> Shape:
    t = Triad(tip)
    shape: Shape = [
        (SILVER, t.drum("s", (6, 32), SMALL, 2)),
        (STEEL, t.drum("s", (0, 6), 31.5, 1)),
        (BLACK, t.drum("s", (-0.4, 4), 15.5, sides=20)),
    ]
    for x, z in ((17.7, 17.7), (17.7, -17.7), (-17.7, 17.7), (-17.7, -17.7)):
        shape.append((BLACK, t.moved(x, 0, z).drum("s", (-0.4, 4), 3.2, sides=8)))
    return shape
