"""The LBR iiwa: round links that fold half and half around each cross joint."""

from __future__ import annotations

from collections.abc import Mapping

from ..design import Design
from ..mesh import Paint, Shape
from ..parts import Triad, in_link_frames
from .paints import BLACK, DARK, ORANGE, SILVER, STEEL

RADII = {2: 72.0, 4: 68.0, 6: 60.0}  # of the housings of the cross joints
NECK = {2: 66.0, 4: 62.0, 6: 52.0}
GAP = 2.0


def iiwa(design: Design) -> Mapping[str, Shape]:
    heights = [float(1000 * axis.point[2]) for axis in design.chain.axes]
    tip = float(1000 * design.chain.flange[2, 3])
    seams = {1: 158.0, 3: heights[2] + 195.0, 5: heights[4] + 190.0}
    drawn = {"base_link": _base(seams[1])}
    for joint, side in ((2, -1), (4, 1), (6, -1)):
        z = heights[joint - 1]
        above = seams.get(joint + 1, tip - 62.0)
        below = seams[joint - 1]
        drawn[f"link_{joint - 1}"] = _half(z, below, joint, side)
        drawn[f"link_{joint}"] = _half(z, above, joint, -side)
    drawn["link_7"] = _flange(tip)
    return in_link_frames(design, drawn)


def _base(top: float) -> Shape:
    t = Triad()
    shape: Shape = [
        (SILVER, t.body([(0, 0, 0, 102, 102, 3), (26, 0, 0, 100, 100, 2.8)], 6, axis="n")),
        (SILVER, t.turned([(24, 92), (40, 80), (70, 73), (110, 70), (top - 10, 70)])),
        (DARK, t.turned([(top - 10, 68), (top - GAP, 68)])),
        (BLACK, t.drum("a", (-112, -60), 24, 4, sides=20)),
    ]
    return shape


def _half(z: float, end: float, joint: int, side: int) -> Shape:
    """From the cross joint at height `z` to the seam at height `end`; the housing's half on `side`."""
    r, neck = RADII[joint], NECK[joint]
    way = 1.0 if end > z else -1.0
    depth = r + 4
    shift = 0.5 * side * depth
    long = abs(end - z)
    turned = max(0.35 * long, r)
    body = [
        (z - way * 0.55 * r, 0, 0.92 * shift, 0.62 * r, 0.36 * depth, 2.6),
        (z, 0, shift, r, 0.5 * depth - GAP, 3.2),
        (z + way * 0.45 * r, 0, 0.9 * shift, 0.98 * r, 0.55 * depth, 3.0),
        (z + way * turned, 0, 0.25 * shift, 0.5 * (r + neck), 0.82 * neck, 2.3),
        (end - way * 0.14 * long, 0, 0, neck, neck, 2),
        (end - way * GAP, 0, 0, neck, neck, 2),
    ]
    t = Triad((0, 0, z))
    low, high = sorted((side * GAP, side * (depth + 2)))
    outer = side * (depth + 2)
    ring = sorted((outer, outer + side * 4))
    cap = sorted((outer, outer + side * 9))
    shell = Triad()
    return [
        (SILVER, shell.body(body, axis="n", sides=32)),
        (SILVER, t.drum("s", (low, high), r, 6, sides=32)),
        (ORANGE, t.drum("s", (ring[0], ring[1]), 0.80 * r, sides=32)),
        (DARK, t.drum("s", (cap[0], cap[1]), 0.72 * r, 3, sides=28)),
        (_accent(joint), shell.turned([(end - way * 7, 1.012 * neck), (end - way * GAP, 1.012 * neck)])),
    ]


def _accent(joint: int) -> Paint:
    return DARK if joint in RADII else ORANGE


def _flange(tip: float) -> Shape:
    t = Triad((0, 0, tip))
    shape: Shape = [
        (SILVER, t.turned([(-60, 50), (-30, 48), (-18, 44)])),
        (BLACK, t.turned([(-18, 42), (-14, 42)])),
        (STEEL, t.drum("n", (-14, 0), 40, 2)),
        (BLACK, t.drum("n", (-6, 0.4), 16, sides=20)),
    ]
    for x, y in ((25, 0), (-25, 0), (0, 25), (0, -25)):
        shape.append((BLACK, t.moved(x, y, 0).drum("n", (-6, 0.4), 3.5, sides=8)))
    return shape
