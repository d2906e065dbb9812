"""Repeats of poses: how far points are off the mean of their repeats, what passes slowly taken out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..campaign.problem import Problem
from ..effects.coming_to_rest import SHARES, share_gone
from ..robot.kinematics import Array
from ..robot.rotations import body_jacobian

WAVES = 3  # cosines in time: what a stand or a hall does in a day
ALIKE = 0.05  # of the largest: a function beside the others by less is no further one
MOST = 5  # functions that are tried
ROOM = 3.0  # times as many degrees of freedom as functions are tried
DRAWS, SURELY = 24, 3.0  # of the same functions in random order; standard deviations that are no chance


def repeat_groups(problem: Problem, sides: bool = True) -> NDArray[np.int64]:
    """(N,) number of the group of repeats of each pose: of equal command, load and set-up; and approach, if
    sides count."""
    c = problem.campaign
    parts = [
        np.round(c.poses.q, 9),
        c.poses.payload[:, None],
        np.round(c.poses.wrench, 6),
        c.poses.setup[:, None],
    ]
    if sides and c.poses.side is not None:
        parts.append(c.poses.side)
    _, group = np.unique(np.hstack(parts), axis=0, return_inverse=True)
    return np.asarray(group.ravel(), dtype=np.int64)


def within(points: Array, group: NDArray[np.int64]) -> tuple[Array, Array, int]:
    """Deviation (N, T, 3) of each pose's points from their means in the pose's group (0 where not seen),
    1 − 1/k of each point (N, T) that k poses of the group show (0: alone, or not seen), and the degrees of
    freedom."""
    deviation, weight, dof = np.zeros_like(points), np.zeros(points.shape[:2]), 0
    order = np.argsort(group, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
        if len(members) > 1:
            seen = np.isfinite(points[members])
            count = seen.sum(axis=0)
            weight[members] = np.where(seen.all(axis=2), 1 - 1 / np.maximum(count.min(axis=1), 1), 0.0)
            mean = np.where(seen, points[members], 0.0).sum(axis=0) / np.maximum(count, 1)
            deviation[members] = np.where(seen, points[members] - mean, 0.0)
            dof += int(np.maximum(count - 1, 0).sum())
    return deviation, weight, dof


def scatter_of_repeats(problem: Problem) -> tuple[Array, Array, int]:
    """What repeats scatter by: deviation (N, T, 3) [m] of points from the mean of their repeats, its variance
    over that of a point (N, T) (0: alone), and the degrees of freedom.

    Repeats hours apart differ as well by what has moved or grown meanwhile. Where shift, turn and growth
    of all points of a set-up, smooth in time or proportional to temperature, surely leave less of that than
    the same in random order, they are no scatter: a drift would be taken for noise, and hide in it. By the
    logarithm of what is left: of few repeats that drift far, functions in any order explain more than half,
    and none can explain more than all."""
    group = repeat_groups(problem)
    deviation, weight, dof = within(problem.campaign.points, group)
    setup = problem.campaign.poses.setup
    repeated = (weight > 0).any(axis=1)
    for k in np.unique(setup[repeated]):
        here = (setup == k) & repeated
        own = within(problem.campaign.points[here], group[here])[2]
        motions, d = _rigid_and_growth(problem, here), deviation[here].ravel()
        slow = _slow(problem, here)[:, : int(own / ROOM / motions.shape[3])]
        if not slow.size:
            continue
        passing = _span(slow, motions, group[here])
        rng = np.random.default_rng(0)
        drawn = [_span(rng.permutation(slow), motions, group[here]) for _ in range(DRAWS)]
        chance = [_log_left(functions, d) for functions in drawn]
        if _log_left(passing, d) > np.mean(chance) - SURELY * np.std(chance):
            continue
        taken = passing @ (passing.T @ d)
        rank = passing.shape[1]
        deviation[here] = (d - taken).reshape(deviation[here].shape)
        weight[here] *= (own - rank) / own
        dof -= rank
    return deviation, weight, dof


def _span(slow: Array, motions: Array, group: NDArray[np.int64]) -> Array:
    """(3NT, r) orthonormal: what each of the motions (N, T, 3, m) times each function (N, k) can make of the
    deviations from the means of the groups (N,)."""
    n, targets = motions.shape[:2]
    every = slow[:, None, None, :, None] * motions[:, :, :, None]
    columns = every.reshape(n, targets, 3, -1).transpose(0, 3, 1, 2).reshape(n, -1, 3)
    off = (
        within(columns, group)[0]
        .reshape(n, -1, targets, 3)
        .transpose(0, 2, 3, 1)
        .reshape(3 * n * targets, -1)
    )
    U, s, _ = np.linalg.svd(off, full_matrices=False)
    return np.asarray(U[:, s > 1e-9 * s.max(initial=1e-300)])


def _log_left(functions: Array, d: Array) -> float:
    """Logarithm of what orthonormal functions (m, r) leave of the square of d (m,)."""
    whole = float(d @ d)
    left = whole - float(((functions.T @ d) ** 2).sum())
    return float(np.log(max(left, 1e-12 * whole, 1e-300)))


def _rigid_and_growth(problem: Problem, here: NDArray[np.bool_]) -> Array:
    """(N, T, 3, 7) motion of the points at the poses `here` by shift, turn and growth of all; NaN where not
    seen."""
    off = problem.campaign.points[here]
    off = off - np.nanmean(off.reshape(-1, 3), axis=0)
    every = np.concatenate([body_jacobian(np.nan_to_num(off)), off[..., None]], axis=3)
    return np.where(problem.seen[here][..., None, None], every, np.nan)


def _slow(problem: Problem, here: NDArray[np.bool_]) -> Array:
    """(N, k) functions of time and temperature, as many as the poses `here` tell apart, smoothest first."""
    functions = []
    if problem.time is not None and (span := float(np.ptp(problem.time[here]))) > 0:
        since = problem.time[here] - problem.time[here].min()
        functions += [np.cos(np.pi * k * since / span) for k in range(1, WAVES + 1)]
        functions += [since / span, *(share_gone(since, share * span) for share in SHARES)]
    if problem.warmth is not None and np.ptp(problem.warmth[here]) > 0:
        functions.append(problem.warmth[here])
    F = np.array([f - f.mean() for f in functions if np.ptp(f) > 0]).reshape(-1, int(here.sum()))
    if not len(F):
        return F.T
    U, s, _ = np.linalg.svd((F / F.std(axis=1, keepdims=True)).T, full_matrices=False)
    return np.asarray(U[:, : min(MOST, int(np.sum(s > ALIKE * s[0])))])
