"""How much more a change scatters from posture to posture than by the noise, where the model does not fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .candidates import Shape
from .coherence import neighbours
from .system import Solved, System, moved_without_parts

GROUP = 8  # poses at most that are left out together: what the model lacks is alike in neighbours


def unsteady(system: System, shapes: Sequence[Shape], scales: Sequence[float], solved: Solved) -> list[float]:
    """Of each shape, 1 or more: the factor on the standard deviation of its size, without neighbouring poses
    after each other (delete-a-group jackknife of each campaign: Kott 2001), over that by the noise."""
    moved = moved_without_parts(system, shapes, scales, solved, _parts_by_posture(system))
    out, at = [], solved.background
    for shape in shapes:
        own = slice(at, at + shape.width)
        at += shape.width
        half = solved.half[own]
        along = np.linalg.lstsq(half @ half.T, solved.values[own])[0]  # the size is along . values
        by_noise = float(((along @ half) ** 2).sum())
        shown = 0.0
        for part in moved:
            each = part[:, own] @ along
            shown += (len(each) - 1) * float(np.var(each))
        out.append(float(np.sqrt(max(shown / by_noise, 1.0))))
    return out


def _parts_by_posture(system: System) -> list[NDArray[np.int64]]:
    """(R,) of each occasion: the number of the group of each row's pose."""
    out, first = [], 0
    for one in system.occasions:
        q, of = one.problem.q, np.full(int(system.pose[-1]) + 1, -1)
        for i, group in enumerate(neighbours(q, np.arange(len(q)), GROUP)):
            of[first + group] = i
        first += len(q)
        out.append(of[system.pose])
    return out
