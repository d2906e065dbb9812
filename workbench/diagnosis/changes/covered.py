"""Which poses can speak of a change: those within what the campaigns on its other side covered; and how well
all can where the model does not fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...robot.kinematics import Array
from ...robot.ranges import beyond_range
from .system import Mask, System

HALF = 0.5  # of the poses: where fewer are covered, two campaigns hardly share a posture


def covered(system: System, pattern: Array, joint: str | None) -> Mask:
    """(R,) rows at poses that have a joint within what some occasion with another share of the change
    covered. pattern: (K, c) the occasions' shares."""
    every = [one.problem.q for one in system.occasions]
    j = system.occasions[0].problem.arm.names.index(str(joint))
    here = []
    for q, share in zip(every, pattern, strict=True):
        met = np.zeros(len(q), dtype=bool)
        for other, theirs in zip(every, pattern, strict=True):
            if not np.array_equal(share, theirs):
                met |= ~beyond_range(q, other.min(axis=0), other.max(axis=0))[:, j]
        here.append(met)
    return np.asarray(np.concatenate(here)[system.pose])


def inside(system: System, k: int, others: Sequence[int]) -> NDArray[np.bool_]:
    """(N,) poses of occasion k that have every joint within what some of these others covered."""
    return np.any([system.within[k][i] for i in others], axis=0)


def hardly(system: System, k: int, others: Sequence[int]) -> bool:
    """Whether fewer than half of the poses of occasion k are inside."""
    return float(inside(system, k, others).mean()) < HALF


def carried(system: System, k: int, others: Sequence[int]) -> float:
    """Factor on standard deviations of what differs between occasion k and these others, where the model does
    not fit: poses in which the other side was not share what the model lacks there, as far as that is alike
    in neighbouring ones (design effect: Kish 1965).

    Of two draws over one range some poses are always outside: what counts is by how much more these are than
    half.
    """
    return _design(system, others, [k])


def carried_change(system: System, pattern: Array) -> float:
    """The same of a change, between the occasions with the first's share of it and all others. pattern:
    (K, c) the occasions' shares."""
    first = np.all(pattern == pattern[0], axis=1)
    return _design(system, np.flatnonzero(first).tolist(), np.flatnonzero(~first).tolist())


def _design(system: System, before: Sequence[int], after: Sequence[int]) -> float:
    if not system.misfit or not after:
        return 1.0
    ways = ((before, after), (after, before))
    sides = [np.concatenate([inside(system, i, there) for i in here]) for here, there in ways]
    beyond = max(max(float(np.mean(~here)) for here in sides) / HALF - 1.0, 0.0)
    alike = beyond**2 * max(one.coherence for one in system.occasions)  # beyond²: share of pairs of poses
    count = len(sides) / sum(1.0 / len(here) for here in sides)
    return float(np.sqrt(1.0 + alike * (count - 1.0)))
