"""Which poses can speak of a change: those within what the campaigns on its other side covered."""

from __future__ import annotations

import numpy as np

from ...identification.prediction.ranges import beyond_range
from ...robot.kinematics import Array
from .system import Mask, System


def covered(system: System, pattern: Array, joint: str | None = None) -> Mask:
    """(R,) rows at poses that have every joint, or this one, within what some occasion with another share of
    the change covered. pattern: (K, c) the occasions' shares."""
    every = [one.problem.q for one in system.occasions]
    names = system.occasions[0].problem.arm.names
    some = slice(None) if joint is None else [names.index(joint)]
    here = []
    for q, share in zip(every, pattern, strict=True):
        inside = np.zeros(len(q), dtype=bool)
        for other, theirs in zip(every, pattern, strict=True):
            if not np.array_equal(share, theirs):
                inside |= ~beyond_range(q, other.min(axis=0), other.max(axis=0))[:, some].any(axis=1)
        here.append(inside)
    return np.asarray(np.concatenate(here)[system.pose])
