"""The shortest re-check: which of the measured poses would show a change again."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from ...robot.kinematics import Array
from ..telling.power import POWER
from .candidates import Candidate, Shape
from .sensitivity import threshold
from .system import Solved, System

FIRST = 3  # poses far from each other, before any information can be compared
MOST = 30
LEAST = 0.5  # information that every number has, in prior sizes, whichever half of the poses shows it
TYPICAL_Z = 5.0  # standard deviations near which a change is named


@dataclass(frozen=True, eq=False)
class Known:
    """What is known without a change: the numbers by the campaigns before, a factor on their noise, and
    whether the model misfits these."""

    numbers: Solved
    factor: float
    misfit: bool


def recheck(
    system: System, before: Known, candidate: Candidate, shape: Shape, value: Array
) -> tuple[int | None, tuple[str, ...]]:
    """How many poses, and which, would show `value` (g,) (in prior sizes) with 80 % power, compared with the
    campaigns that do not have it: frame and targets are fitted anew, the robot is known as well as `before`,
    by these alone; where the model misfits these, either half must show it, every other pose. None: more than
    30, or than there are."""
    k = int(np.flatnonzero(shape.pattern[:, 0])[-1])
    one = system.occasions[k]
    rows = np.flatnonzero(system.own == k)
    poses = one.problem.campaign.poses.in_setup_of(0)
    pick = rows.reshape(-1, len(rows) // len(one.problem.q))[poses]
    X = np.concatenate([system.J[pick][..., system.local[k]], system.J[pick][..., system.common]], axis=2)
    c = shape.columns[pick] @ value
    halves = 2 if before.misfit else 1
    local = system.local[k].stop - system.local[k].start
    half = before.numbers.half[system.common]
    known = np.eye(X.shape[2])
    inverse = np.linalg.pinv(half)
    known[local:, local:] = inverse.T @ inverse / halves
    information = (TYPICAL_Z / max(float(np.linalg.norm(value)), 1e-12)) ** 2
    target = (threshold(candidate, information) + norm.isf(1 - POWER)) * before.factor
    left, found = list(range(len(poses))), list[list[int]]()
    for _ in range(halves):
        chosen = _enough(X, c, known, one.problem.q[poses], left, target)
        if chosen is None or sum(map(len, found)) + len(chosen) > MOST:
            return None, ()
        found.append(chosen)
        left = [n for n in left if n not in chosen]
    order = [n for some in itertools.zip_longest(*found) for n in some if n is not None]
    ids = one.problem.campaign.poses.ids
    return len(order), tuple(ids[poses[n]] for n in order)


def _enough(
    X: Array, c: Array, known: Array, q: Array, poses: Sequence[int], target: float
) -> list[int] | None:
    """Some of the poses that show a change of `target` standard deviations, each next one by what it brings;
    None where all do not. X: (N, D, P) of all else, c: (N, D) of the change, known: (P, P) information
    before, q: (N, n)."""
    chosen = _spread(q, poses)
    M, cross, own = known, np.zeros(X.shape[2]), 0.0
    for n in chosen:
        M, cross, own = M + X[n].T @ X[n], cross + X[n].T @ c[n], own + float(c[n] @ c[n])
    while own - cross @ (inverse := _inverse(M)) @ cross < target**2:
        left = [n for n in poses if n not in chosen]
        if not left or len(chosen) >= MOST:
            return None
        best = max(left, key=lambda n: _gain(X[n], c[n], inverse, cross))
        chosen.append(best)
        M, cross = M + X[best].T @ X[best], cross + X[best].T @ c[best]
        own += float(c[best] @ c[best])
    return chosen


def _inverse(M: Array) -> Array:
    """Of information (P, P) in prior sizes: at least that of half a prior, which rounding may take from what
    the poses do not tell apart."""
    values, vectors = np.linalg.eigh(M)
    return np.asarray(vectors / np.maximum(values, LEAST) @ vectors.T)


def _gain(X: Array, c: Array, inverse: Array, cross: Array) -> float:
    """What a pose adds to the information on the change beside everything else."""
    left = c - X @ (inverse @ cross)
    return float(left @ np.linalg.solve(np.eye(len(c)) + X @ inverse @ X.T, left))


def _spread(q: Array, poses: Sequence[int]) -> list[int]:
    """`FIRST` of the poses, far from each other: each next one farthest from those before."""
    chosen = [*poses[:1]]
    while len(chosen) < min(FIRST, len(poses)):
        near = {n: min(float(np.linalg.norm(q[n] - q[m])) for m in chosen) for n in poses}
        chosen.append(max(poses, key=lambda n: near[n]))
    return chosen
