"""Plain looks."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .mesh import Paint, Shape
from .parts import drum

ORANGE = Paint((255, 102, 10))
DARK = Paint((45, 47, 50))


def plain(design: object) -> Mapping[str, Shape]:
    from .files import link_frames

    frames = link_frames(design)
    points = [X[:3, 3] * 1000 for X in frames] + [design.chain.flange[:3, 3] * 1000]
    shapes: dict[str, Shape] = {"base_link": [(DARK, drum((0, 0, 0), (0, 0, 30), 100))]}
    for i, axis in enumerate(design.chain.axes):
        p, q = points[i], points[i + 1]
        d = axis.direction
        parts = [(DARK, drum(p - 50 * d, p + 50 * d, 45, 5))]
        if np.linalg.norm(q - p) > 20:
            parts.append((ORANGE, drum(p, q, 40)))
        R = frames[i][:3, :3].T
        shapes[f"link_{i + 1}"] = [(c, m.moved(R, -R @ p)) for c, m in parts]
    return shapes
