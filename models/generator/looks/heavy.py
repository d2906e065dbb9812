"""Heavy six-axis arms: a column, an arm on one side of it, a forearm with the wrist motors behind."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..design import Design
from ..mesh import Array, Shape
from ..parts import Triad, in_link_frames
from .arms import Places, Sizes, flange, foot, places, tube, wrist
from .paints import BLACK, DARK


def heavy(design: Design, z: Sizes, floor: float = 0.0) -> Mapping[str, Shape]:
    """Every link's shape; `floor`: where the foot stands, on axis 1 in the frame of drawing [mm]."""
    p = places(design)
    drawn = {
        "base_link": foot(z, floor),
        "link_1": _column(z, p, floor),
        "link_2": _arm(z, p),
        "link_3": _forearm(z, p),
        "link_4": tube(z, p),
        "link_5": wrist(z, p),
        "link_6": flange(z, p),
    }
    if design.compensator is not None and z.cylinder > 0:
        fixed = 1000 * (np.array(design.compensator["body_pivot"]) + design.chain.axes[0].point)
        drawn["link_1"] += _lugs(z, fixed)
    return in_link_frames(design, drawn, p.X_BD)


def _column(z: Sizes, p: Places, floor: float) -> Shape:
    x2, y2, z2 = p.shoulder.at(0, 0, 0)
    t, h, b = Triad((0, 0, floor)), z.turntable, z.block
    low = h + 0.16 * b
    block = [
        (-0.62 * b, low + 0.22 * b, 0.22 * b),
        (0.80 * b, low + 0.22 * b, 0.22 * b),
        (0.62 * b, low + 0.62 * b, 0.25 * b),
        (-0.55 * b, low + 0.78 * b, 0.25 * b),
    ]
    cheek = [
        (x2, z2 - floor, 0.98 * z.hub),
        (0.35 * b, low + 0.3 * b, 0.3 * b),
        (-0.45 * b, low + 0.5 * b, 0.3 * b),
    ]
    gear, beside = Triad((x2, y2, z2)), Triad((0, y2, floor))
    motor = z.motor
    rear = t.moved(-0.5 * b, -0.42 * b, 0)
    shape = [
        (z.paint, t.drum("n", (h, h + 0.2 * b), 1.02 * z.waist, 0.05 * b, sides=32)),
        (z.paint, t.slab(block, (-0.66 * b, 0.66 * b), 0.08 * b)),
        (z.paint, beside.slab(cheek, (z.cheek - 0.62 * b, z.cheek), 0.07 * b)),
    ]
    if motor == 0:
        cap = 0.06 * z.hub
        return [*shape, (z.cover, gear.drum("s", (z.cheek - cap, z.cheek + cap), 0.70 * z.hub, cap))]
    return [
        *shape,
        (DARK, gear.drum("s", (z.cheek, z.cheek + 0.28 * motor), 0.78 * z.hub, 0.1 * motor)),
        (DARK, gear.drum("s", (z.cheek, z.cheek + 0.9 * motor), 1.25 * motor, 0.2 * motor)),
        (BLACK, gear.drum("s", (z.cheek + 0.9 * motor, z.cheek + 3.3 * motor), motor, 0.2 * motor)),
        (DARK, rear.drum("n", (low + 0.9 * b, low + 1.12 * b), 1.25 * motor, 0.15 * motor)),
        (BLACK, rear.drum("n", (low + 1.12 * b, low + 1.12 * b + 2.2 * motor), motor, 0.2 * motor)),
    ]


def _arm(z: Sizes, p: Places) -> Shape:
    t = p.shoulder
    length, r, e = p.upper, z.hub, z.elbow
    thick = z.near - z.far
    edge = 0.14 * thick
    beam = [(0.0, 0.0, 0.80 * r), (length, 0.0, 0.80 * e)]
    ridge = [(0.35 * r, 0.0, 0.42 * r), (length - 0.35 * e, 0.0, 0.42 * e)]
    over = t.moved(length, 0, 0)
    cover = 0.05 * thick
    return [
        (z.paint, t.slab(beam, (z.far + 0.06 * thick, z.near - 0.06 * thick), edge)),
        (z.paint, t.slab(ridge, (z.far - 0.06 * thick, z.far + 0.2 * thick), 0.06 * thick)),
        (z.paint, t.drum("s", (z.far, z.near), r, edge, sides=36)),
        (z.paint, over.drum("s", (z.far, z.near), e, edge, sides=32)),
        (z.joint, t.drum("s", (z.near, z.cheek - 0.62 * z.block), 0.92 * r, 0.03 * r)),
        (z.cover, t.drum("s", (z.far - 2.2 * cover, z.far + cover), 0.66 * r, cover)),
        (z.cover, over.drum("s", (z.far - 2.2 * cover, z.far + cover), 0.62 * e, cover)),
    ]


def _forearm(z: Sizes, p: Places) -> Shape:
    t, drop = p.elbow, p.drop
    g, e, start, tip = z.forearm, z.elbow, z.tube_start, z.tube
    casting = [
        (-1.45 * g, 0, drop, 0.80 * g, 0.84 * g, 5),
        (-0.7 * g, 0, drop, 0.92 * g, 0.98 * g, 5),
        (0.35 * g, 0, drop, 0.92 * g, 1.0 * g, 4.5),
        (0.45 * start + 0.3 * g, 0, drop, 0.5 * g + 0.45 * tip, 0.5 * g + 0.45 * tip, 3),
        (start - 0.10 * g, 0, drop, 1.06 * tip, 1.06 * tip, 2),
        (start, 0, drop, 1.06 * tip, 1.06 * tip, 2),
    ]
    if z.motor == 0:
        casting = [(-1.0 * g, 0, drop, 0.70 * g, 0.74 * g, 4), *casting[1:]]
    face = 1.02 * g
    shape = [
        (z.paint, t.body(casting, 0.1 * g, sides=32)),
        (z.paint, t.drum("s", (z.near + 4, face), 0.92 * e, 0.06 * e, sides=32)),
    ]
    if abs(drop) > 0.5 * e:
        bridge = [(0.0, 0.0, 0.88 * e), (-0.25 * g, drop, 0.85 * g), (0.15 * g, drop, 0.85 * g)]
        shape.append((z.paint, t.slab(bridge, (-0.72 * g, 0.86 * g), 0.1 * g)))
    if z.motor == 0:
        return [*shape, (z.cover, t.drum("s", (face - 0.1 * e, face + 0.05 * e), 0.62 * e, 0.05 * e))]
    m = 0.72 * z.motor
    shape += [
        (DARK, t.drum("s", (face, face + 0.9 * z.motor), 1.2 * z.motor, 0.2 * z.motor)),
        (BLACK, t.drum("s", (face + 0.9 * z.motor, face + 2.7 * z.motor), z.motor, 0.2 * z.motor)),
        (DARK, t.moved(0, 0, drop).drum("a", (-1.58 * g, -1.4 * g), 0.80 * g, 0.05 * g)),
    ]
    for side, up, long in ((-0.40, 0.30, 1.0), (0.40, 0.30, 1.0), (0.0, -0.40, 0.8)):
        at = t.moved(0, side * g, drop + up * g)
        shape.append((BLACK, at.drum("a", (-1.55 * g - 3.0 * m * long, -1.5 * g), m, 0.2 * m, sides=24)))
    return shape


def _lugs(z: Sizes, fixed: Array) -> Shape:
    """What holds the compensator on the column; tube and rod move, and are drawn where the robot is."""
    c = z.cylinder
    foot = Triad()
    b, low = z.block, z.turntable + 0.16 * z.block
    lug = [(fixed[0], fixed[2], 0.85 * c), (-0.55 * b, low + 0.5 * b, 0.3 * b)]
    spans = ((-1.6 * c, -1.1 * c), (1.1 * c, 1.6 * c))
    return [(z.paint, foot.slab(lug, span, 0.08 * c, sides=28)) for span in spans]
