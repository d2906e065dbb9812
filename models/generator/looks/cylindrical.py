"""The cylindrical robot: a turning column with two rails, a carriage on them, a beam through it."""

from __future__ import annotations

from collections.abc import Mapping

from ..design import Design
from ..mesh import Shape
from ..parts import Triad, box, in_link_frames
from .paints import BLACK, DARK, GREY, STEEL, TEAL, WHITE

TOP = 1290.0


def cylindrical(design: Design) -> Mapping[str, Shape]:
    lift = float(1000 * design.chain.axes[1].point[2])
    tip = float(1000 * design.chain.flange[0, 3])
    drawn = {
        "base_link": _base(),
        "link_1": _column(),
        "link_2": _carriage(lift),
        "link_3": _beam(lift, tip),
    }
    return in_link_frames(design, drawn)


def _base() -> Shape:
    t = Triad()
    shape: Shape = [
        (DARK, t.body([(-80, 0, 0, 330, 330, 8), (-46, 0, 0, 330, 330, 8)], 8, axis="n")),
        (GREY, t.turned([(-46, 270), (0, 250), (40, 238), (84, 238)], sides=36)),
        (BLACK, t.turned([(84, 222), (96, 222)], sides=36)),
    ]
    for x in (-270, 270):
        for y in (-270, 270):
            shape.append((STEEL, t.moved(x, y, 0).drum("n", (-46, -30), 18, sides=8)))
    return shape


def _column() -> Shape:
    t = Triad()
    shape: Shape = [
        (WHITE, t.drum("n", (96, 168), 240, 16, sides=36)),
        (WHITE, box(t, (-130, 130), (-215, 215), (168, 230), 22)),
        (WHITE, box(t, (-110, 110), (-215, 215), (TOP - 60, TOP), 22)),
        (DARK, t.moved(-150, 0, 0).drum("n", (TOP - 50, TOP + 120), 58, 8)),
        (BLACK, t.moved(-150, 0, 0).drum("n", (TOP + 120, TOP + 190), 50, 8)),
        (STEEL, t.moved(-150, 0, 0).drum("n", (225, TOP - 45), 14, sides=14)),
        (WHITE, box(t, (-200, -100), (-60, 60), (168, 235), 20)),
        (WHITE, box(t, (-215, -100), (-70, 70), (TOP - 60, TOP - 4), 20)),
    ]
    for y in (-165, 165):
        shape.append((STEEL, t.moved(0, y, 0).drum("n", (225, TOP - 55), 30, sides=26)))
        shape.append((TEAL, t.moved(0, y, 0).drum("n", (TOP - 4, TOP + 10), 40, 4, sides=26)))
    return shape


def _carriage(lift: float) -> Shape:
    t = Triad((0, 0, lift))
    shape: Shape = [
        (WHITE, box(t, (-105, 105), (-225, 225), (-78, 78), 26)),
        (WHITE, box(t, (-150, 150), (-92, 92), (-92, 92), 24)),
        (DARK, box(t, (-185, -110), (-40, 40), (-60, 60), 14)),
        (DARK, t.moved(60, 0, 0).drum("n", (90, 108), 54, 4)),
        (BLACK, t.moved(60, 0, 0).drum("n", (108, 210), 44, 8)),
    ]
    for y in (-165, 165):
        shape.append((DARK, t.moved(0, y, 0).drum("n", (-100, 100), 50, 6, sides=28)))
    for x in (-152, 146):
        shape.append((BLACK, box(t, (x, x + 6), (-62, 62), (-62, 62), 10)))
    return shape


def _beam(lift: float, tip: float) -> Shape:
    t = Triad((0, 0, lift))
    return [
        (GREY, box(t, (-620, tip - 70), (-48, 48), (-48, 48), 10)),
        (STEEL, box(t, (-600, tip - 80), (-54, 54), (-14, 14), 3)),
        (TEAL, box(t, (-645, -615), (-58, 58), (-58, 58), 12)),
        (DARK, box(t, (tip - 75, tip - 22), (-62, 62), (-62, 62), 14)),
        (STEEL, t.drum("a", (tip - 24, tip), 50, 3)),
        (BLACK, t.drum("a", (tip - 6, tip + 0.5), 20, sides=20)),
    ]
