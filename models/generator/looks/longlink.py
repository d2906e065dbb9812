"""The long-link arm: joint drums in forks, tapered booms between them, on a pedestal."""

from __future__ import annotations

from collections.abc import Mapping

from ..design import Design
from ..mesh import Shape
from ..parts import Triad, in_link_frames
from .paints import BLACK, DARK, GREY, STEEL, TEAL, WHITE

# Joints 1..6: axis, radius of the drum, half of its length.
JOINTS = (("n", 165, 150), ("s", 135, 120), ("s", 92, 95), ("n", 84, 85), ("s", 66, 66), ("n", 54, 56))
FLOOR = -900.0


def longlink(design: Design) -> Mapping[str, Shape]:
    places = [float(1000 * axis.point[0]) for axis in design.chain.axes]
    tip = float(1000 * design.chain.flange[0, 3])
    drawn = {"base_link": _pedestal(), "link_6": _joint(5, places[5]), "link_7": _hand(places[6], tip)}
    for i in range(5):
        drawn[f"link_{i + 1}"] = _joint(i, places[i]) + _boom(i, places[i], places[i + 1])
    x = places[5]
    drawn["link_6"].append((WHITE, Triad((x, 0, 0)).turned([(30, 52), (105, 52), (112, 48)], "a")))
    return in_link_frames(design, drawn)


def _pedestal() -> Shape:
    t = Triad()
    low, high = FLOOR, -float(JOINTS[0][2])
    column = [
        (low + 40, 0, 0, 240, 240, 4),
        (low + 160, 0, 0, 205, 205, 3),
        (high - 120, 0, 0, 180, 180, 2.2),
        (high - 60, 0, 0, 185, 185, 2),
        (high - 14, 0, 0, 185, 185, 2),
    ]
    shape: Shape = [
        (DARK, t.body([(low, 0, 0, 310, 310, 9), (low + 40, 0, 0, 310, 310, 9)], 8, axis="n")),
        (GREY, t.body(column, axis="n")),
        (BLACK, t.drum("n", (high - 14, high), 160)),
    ]
    for x in (-255, 255):
        for y in (-255, 255):
            shape.append((STEEL, t.moved(x, y, 0).drum("n", (low + 40, low + 56), 18, sides=8)))
    return shape


def _joint(i: int, x: float) -> Shape:
    axis, r, half = JOINTS[i]
    t = Triad((x, 0, 0))
    shape = [(DARK, t.drum(axis, (-half, half), r, 0.06 * r))]
    if i == 0:
        shape.append((TEAL, t.drum(axis, (half - 2, half + 0.08 * r), 0.74 * r, 0.05 * r)))
    return shape


def _boom(i: int, start: float, end: float) -> Shape:
    """From the drum of joint i+1 to the fork that holds the drum of the next joint."""
    (own, r, half), (axis, r2, half2) = JOINTS[i], JOINTS[i + 1]
    t = Triad((start, 0, 0))
    length = end - start
    wide = half2 + 0.24 * r2
    fork = length - 1.12 * r2
    near = 0.5 * min(r, half) if own == "n" else 0.55 * r
    side, up = (wide, 0.86 * r2) if axis == "s" else (0.86 * r2, wide)
    root_side, root_up = (0.74 * half, 0.72 * r) if own == "s" else (0.72 * r, 0.74 * half)
    boom = [
        (near, 0, 0, root_side, root_up, 3),
        (near + 0.3 * (fork - near), 0, 0, 0.5 * (root_side + side) - 0.1 * r2, 0.42 * (root_up + up), 3),
        (fork - 0.5 * r2 if fork - near > r2 else 0.5 * (near + fork), 0, 0, 0.93 * side, 0.9 * up, 3.4),
        (fork, 0, 0, side, up, 4),
    ]
    shape = [(WHITE, t.body(boom, 0.04 * r2))]
    cheek = [(length, 0.0, 0.94 * r2), (fork - 0.1 * r2, 0.0, 0.80 * r2)]
    for way in (-1, 1):
        low, high = sorted((way * (wide - 0.22 * r2), way * wide))
        shape.append((WHITE, t.slab(cheek, (low, high), 0.05 * r2, axis=axis, sides=32)))
        low, high = sorted((way * (wide - 2), way * (wide + 0.08 * r2)))
        shape.append((TEAL, t.moved(length, 0, 0).drum(axis, (low, high), 0.62 * r2, 0.05 * r2, sides=26)))
    return shape


def _hand(start: float, tip: float) -> Shape:
    t = Triad((start, 0, 0))
    long = tip - start
    tube = [(116, 50), (200, 50), (260, 42), (long - 90, 30), (long - 60, 34), (long - 24, 34)]
    shape: Shape = [
        (BLACK, t.turned([(112, 44), (116, 44)], "a")),
        (WHITE, t.turned(tube, "a")),
        (TEAL, t.turned([(196, 51), (214, 51)], "a")),
        (STEEL, t.drum("a", (long - 24, long), 40, 2)),
        (BLACK, t.drum("a", (long - 4, long + 0.4), 16, sides=20)),
    ]
    return shape
