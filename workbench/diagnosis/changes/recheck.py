"""The shortest re-check: which of the measured poses would show a change again."""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from ...robot.kinematics import Array
from ..power import POWER
from .candidates import Candidate, Shape
from .sensitivity import threshold
from .system import Solved, System

FIRST = 3  # poses far from each other, before any information can be compared
MOST = 30
TYPICAL_Z = 5.0  # standard deviations near which a change is named


def recheck(
    system: System, solved: Solved, candidate: Candidate, shape: Shape, value: Array
) -> tuple[int | None, tuple[str, ...]]:
    """How many poses, and which, would show `value` (g,) (in prior sizes) with 80 % power when the instrument
    stands elsewhere and all else is known as well as it is now; None: more than 30, or than there are."""
    k = int(np.flatnonzero(shape.pattern[:, 0])[-1])
    one = system.occasions[k]
    rows = np.flatnonzero(system.own == k)
    setup = one.problem.campaign.poses.setup == one.problem.campaign.poses.setup[0]
    poses = np.flatnonzero(setup)
    per_pose = len(rows) // len(one.problem.q)
    pick = rows.reshape(-1, per_pose)[poses]
    X = np.concatenate([system.J[pick][..., system.local[k]], system.J[pick][..., system.common]], axis=2)
    c = shape.columns[pick] @ value
    local = system.local[k].stop - system.local[k].start
    half = solved.half[system.common]
    known = np.linalg.inv(half @ half.T)
    M = np.eye(X.shape[2])
    M[local:, local:] = known
    information = (TYPICAL_Z / max(float(np.linalg.norm(value)), 1e-12)) ** 2
    target = (threshold(candidate, information) + norm.isf(1 - POWER)) * solved.factor
    chosen = _spread(one.problem.q[poses], min(FIRST, len(poses)))
    cross, own = np.zeros(X.shape[2]), 0.0
    for n in chosen:
        M, cross, own = M + X[n].T @ X[n], cross + X[n].T @ c[n], own + float(c[n] @ c[n])
    while own - cross @ np.linalg.solve(M, cross) < target**2:
        left = [n for n in range(len(poses)) if n not in chosen]
        if not left or len(chosen) >= MOST:
            return None, ()
        inverse = np.asarray(np.linalg.inv(M), dtype=np.float64)
        best = max(left, key=lambda n: _gain(X[n], c[n], inverse, cross))
        chosen.append(best)
        M, cross = M + X[best].T @ X[best], cross + X[best].T @ c[best]
        own += float(c[best] @ c[best])
    ids = one.problem.campaign.poses.ids
    return len(chosen), tuple(ids[poses[n]] for n in chosen)


def _gain(X: Array, c: Array, inverse: Array, cross: Array) -> float:
    """What a pose adds to the information on the change beside everything else."""
    left = c - X @ (inverse @ cross)
    return float(left @ np.linalg.solve(np.eye(len(c)) + X @ inverse @ X.T, left))


def _spread(q: Array, count: int) -> list[int]:
    """Poses far from each other: each next one farthest from those before."""
    chosen = [0]
    while len(chosen) < count:
        near = np.min([np.linalg.norm(q - q[n], axis=1) for n in chosen], axis=0)
        chosen.append(int(np.argmax(near)))
    return chosen
