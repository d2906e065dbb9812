"""What the six-axis arms share: foot, forearm tube with its fork, wrist, flange, and where they are.

Drawn for z up, x forward and the parallel axes 2, 3 and 5 along y. An arm that leans is drawn upright.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..design import Design
from ..mesh import Array, Paint, Shape
from ..parts import Triad, box
from .paints import BLACK, DARK, STEEL

SIDE = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Sizes:
    """Sizes in mm: half-widths, radii, places on an axis.

    `near`, `far`: the upper arm's two faces beside the forearm's plane; `cheek`: the face of the
    column on the other side.
    """

    paint: Paint
    foot: float
    waist: float
    turntable: float
    block: float
    hub: float
    elbow: float
    near: float
    far: float
    cheek: float
    forearm: float
    tube: float
    tube_start: float
    wrist: float
    flange: float
    motor: float = 0.0
    cylinder: float = 0.0
    cover: Paint = BLACK
    joint: Paint = DARK


@dataclass(frozen=True)
class Places:
    """Where the joints are at q = 0 [mm], in the frame of drawing D, and the arm's directions.

    `shoulder`, `elbow`, `hand`, `tip`: triads at joints 2, 3, 5 and the flange, whose `a` points to
    the elbow, along the forearm, along the forearm, and out of the flange.
    """

    X_BD: Array
    shoulder: Triad
    elbow: Triad
    hand: Triad
    tip: Triad
    upper: float
    fore: float
    drop: float
    reach: float
    offset: float


def places(design: Design) -> Places:
    X_BD = np.eye(4)
    X_BD[:3, :3] = design.rotation
    X_BD[2, 3] = design.masses.start or 0.0
    points = [_into(X_BD, 1000 * axis.point) for axis in design.chain.axes]
    end = _into(X_BD, 1000 * design.chain.flange[:3, 3])
    directions = [X_BD[:3, :3].T @ axis.direction for axis in design.chain.axes]
    flat = np.array([1.0, 0.0, 1.0])
    shoulder, elbow, hand = (points[i] * flat + points[4] * SIDE for i in (1, 2, 4))
    a = (elbow - shoulder) / _length(elbow - shoulder)
    f = _towards(directions[3], hand - elbow)
    w = _towards(directions[5], end - hand)
    return Places(
        X_BD=X_BD,
        shoulder=_triad(shoulder, a),
        elbow=_triad(elbow, f),
        hand=_triad(hand, f),
        tip=_triad(end, w),
        upper=_length(elbow - shoulder),
        fore=float((hand - elbow) @ f),
        drop=float((hand - elbow) @ np.cross(f, SIDE)),
        reach=float((end - hand) @ w),
        offset=float((end - hand) @ np.cross(w, SIDE)),
    )


def _into(X: Array, point: Array) -> Array:
    return np.round(X[:3, :3].T @ (point - X[:3, 3]), 9)


def _length(way: Array) -> float:
    return float(np.sqrt(way @ way))


def _towards(direction: Array, way: Array) -> Array:
    return np.round(direction if direction @ way > 0 else -direction, 12)


def _triad(origin: Array, along: Array) -> Triad:
    return Triad(origin, along, SIDE, np.cross(along, SIDE))


def foot(z: Sizes, floor: float) -> Shape:
    """The base: plate, plinth, connector box; it ends at the turntable."""
    t, f = Triad((0, 0, floor)), z.foot
    h = z.turntable
    corner = 0.16 * f
    plate = [(x, y, corner) for x in (corner - f, f - corner) for y in (corner - f, f - corner)]
    plinth = [
        (0.09 * f, 0, 0, 0.86 * f, 0.86 * f, 5),
        (0.22 * h, 0, 0, 0.80 * f, 0.80 * f, 4.6),
        (0.42 * h, 0, 0, 1.06 * z.waist, 1.06 * z.waist, 2.8),
        (0.62 * h, 0, 0, 0.98 * z.waist, 0.98 * z.waist, 2.1),
        (0.86 * h, 0, 0, z.waist, z.waist, 2),
    ]
    shape = [
        (z.joint, t.slab(plate, (0, 0.1 * f), 0.02 * f, axis="n", sides=28)),
        (z.paint, t.body(plinth, axis="n")),
        (BLACK, t.drum("n", (0.86 * h, h), 0.97 * z.waist)),
        (DARK, box(t, (-1.22 * f, -0.7 * f), (-0.42 * f, 0.42 * f), (0.16 * f, 0.6 * h), 0.05 * f)),
    ]
    for x in (-0.8 * f, 0.8 * f):
        for y in (-0.8 * f, 0.8 * f):
            shape.append((STEEL, t.moved(x, y, 0).drum("n", (0.1 * f, 0.14 * f), 0.055 * f, sides=8)))
    return shape


def tube(z: Sizes, p: Places) -> Shape:
    """Link 4: the forearm's front with the fork around joint 5."""
    t, length = p.elbow.moved(0, 0, p.drop), p.fore
    r, w, start = z.tube, z.wrist, z.tube_start
    fork = length - 1.35 * w
    barrel = [
        (start + 0.12 * r, 0, 0, r, r, 2),
        (start + 0.5 * (fork - start), 0, 0, 0.5 * (r + w) + 0.12 * w, 0.5 * (r + w) - 0.02 * w, 2.2),
        (fork, 0, 0, 1.30 * w, 0.98 * w, 3.2),
        (fork + 0.28 * w, 0, 0, 1.32 * w, 0.96 * w, 3.4),
    ]
    cheek = [(length, 0, 0.98 * w), (fork + 0.1 * w, 0, 0.92 * w)]
    shape = [(BLACK, t.drum("a", (start, start + 0.14 * r), 0.96 * r)), (z.paint, t.body(barrel, 0.06 * r))]
    for side in (-1, 1):
        low, high = sorted((side * 0.80 * w, side * 1.32 * w))
        shape.append((z.paint, t.slab(cheek, (low, high), 0.12 * w, sides=32)))
        low, high = sorted((side * 1.30 * w, side * 1.40 * w))
        shape.append((z.cover, p.hand.drum("s", (low, high), 0.64 * w, 0.05 * w, sides=26)))
    return shape


def wrist(z: Sizes, p: Places) -> Shape:
    """Link 5: between the fork's cheeks, out to the flange."""
    w = z.wrist
    t = Triad(p.hand.origin, p.tip.a, p.tip.s, p.tip.n)
    neck = [
        (0, 0, 0.3 * p.offset, 0.76 * w, 0.80 * w, 3),
        (0.75 * w, 0, 0.8 * p.offset, 0.76 * w, 0.80 * w, 2.6),
        (p.reach - 0.75 * w, 0, p.offset, 0.86 * z.flange, 0.86 * z.flange, 2),
        (p.reach - 0.5 * w, 0, p.offset, 0.86 * z.flange, 0.86 * z.flange, 2),
    ]
    return [
        (z.joint, t.drum("s", (-0.78 * w, 0.78 * w), 0.88 * w, 0.06 * w)),
        (z.joint, t.body(neck, 0.04 * w)),
    ]


def flange(z: Sizes, p: Places) -> Shape:
    """Link 6: the flange with its centring and six threads."""
    t, f, w = p.tip, z.flange, z.wrist
    shape = [
        (BLACK, t.drum("a", (-0.5 * w, -0.34 * w), 0.80 * f)),
        (STEEL, t.drum("a", (-0.34 * w, 0), f, 0.05 * f, sides=32)),
        (BLACK, t.drum("a", (-0.05 * w, 0.012 * w), 0.42 * f, sides=22)),
    ]
    for k in range(6):
        c, s = (float(np.round(fn(np.pi * (k / 3 + 1 / 6)), 9)) for fn in (np.cos, np.sin))
        hole = t.moved(0, 0.72 * f * c, 0.72 * f * s)
        shape.append((BLACK, hole.drum("a", (-0.05 * w, 0.012 * w), 0.085 * f, sides=8)))
    return shape
