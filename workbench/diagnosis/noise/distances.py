"""Distances between targets on one body: the robot does not change them, so what they scatter by is noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtr, chdtri

from ...campaign.problem import Problem
from ...effects.unnamed.instrument import may_be_head
from ...identification.noise import Covariance, stated_noise
from ...robot.kinematics import Array

FEWEST = 8  # poses that see the same targets, from which their usual distances are known
SURE = 3.72  # standard deviations: one chance in ten thousand
SHOWN = 0.03  # of the best shown: a combination of distances that noise moves less, as of targets in a plane
WILD = 1e-3  # chance from which a pose's distances are no noise
CAUCHY = 3.5  # usual distances off: 95 % as good as least squares where there is noise alone
MANY = 3.0  # times what there is: no noise is stated so much too large by caution
ROUNDS = 5  # of a fit that wild distances do not pull at


@dataclass(frozen=True)
class Shown:
    """How distances scatter. times: over the stated noise; above: standard deviations that they scatter more
    than that, by the middle of all poses and not the worst; dof: degrees of freedom behind it."""

    times: float
    above: float
    dof: float

    @property
    def more(self) -> bool:
        """Surely more than was stated."""
        return self.above > SURE


def shown_by_distances(problem: Problem, said: Covariance, farthest: bool = False) -> Shown | None:
    """What the distances between targets say of a noise; None where no two stand on one body, or all are
    points of one measurement. farthest: only those that the whole arm carries."""
    bodies = sorted(set(problem.on))[-1:] if farthest else sorted(set(problem.on))
    tests = [] if problem.campaign.six_dof else list(_tests(problem, said, bodies))
    if not tests:
        return None
    share = np.concatenate([chdtr(rank, chi2) for chi2, rank in tests])
    ratio = np.concatenate([chi2 / chdtri(rank, 0.5) for chi2, rank in tests])
    above = (float(share.mean()) - 0.5) * np.sqrt(12 * len(share))
    usual, total, dof = float(np.median(ratio)), 0.0, 0.0
    for chi2, rank in tests:
        kept = chi2[chi2 < usual * chdtri(rank, WILD)]
        total, dof = total + float(kept.sum()), dof + rank * (len(kept) - 1)
    return Shown(float(np.sqrt(total / dof)), above, dof)


def _tests(problem: Problem, said: Covariance, bodies: list[int]) -> Iterator[tuple[Array, int]]:
    """χ² (N,) of the distances at each of N poses that see the same targets of one of the bodies, from their
    medians, and its rank."""
    on, seen, setup = np.array(problem.on), problem.seen, problem.campaign.poses.setup
    for body in bodies:
        mine = np.flatnonzero(on == body)
        pattern = np.column_stack([setup, seen[:, mine]])
        kinds, which = np.unique(pattern, axis=0, return_inverse=True)
        for kind, (_, *sees) in enumerate(kinds):
            targets, poses = mine[np.array(sees, bool)], np.flatnonzero(which.ravel() == kind)
            if len(targets) > 1 and len(poses) >= FEWEST:
                yield _of(problem.campaign.points[poses][:, targets], said.sigma[poses][:, targets])


def _of(points: Array, sigma: Array) -> tuple[Array, int]:
    """χ² (N,) of the distances between points (N, T, 3) from their medians, and its rank; sigma: (N, T)."""
    pairs = np.array(list(combinations(range(points.shape[1]), 2)))
    apart = points[:, pairs[:, 0]] - points[:, pairs[:, 1]]
    length = np.linalg.norm(apart, axis=2)
    off = _without_ranges(length - np.median(length, axis=0), points, pairs, apart / length[..., None])
    way = apart[0] / np.maximum(length[0], 1e-12)[:, None]  # turned alike at all poses
    usual = np.sqrt(np.mean(sigma**2, axis=0))
    slope = np.zeros((len(pairs), points.shape[1], 3))
    rows = np.arange(len(pairs))
    slope[rows, pairs[:, 0]], slope[rows, pairs[:, 1]] = way, -way
    slope *= usual[:, None]
    U, s, _ = np.linalg.svd(slope.reshape(len(pairs), -1), full_matrices=False)
    kept = s > SHOWN * s[0]
    U, s = U[:, kept], s[kept]
    return np.asarray((((off @ U) / s) ** 2).sum(axis=1)), len(s)


def _without_ranges(off: Array, points: Array, pairs: NDArray[np.int64], way: Array) -> Array:
    """(N, P) what distances are off, without what reflectors make whose range is off by a constant each: this
    is the same error at every pose and no noise. pairs: (P, 2) of points (N, T, 3); way: (N, P, 3) between
    them. Fitted with weights by which wild ones do not count (Cauchy's)."""
    if not may_be_head(points.reshape(-1, 3)):
        return off
    ray = points / np.linalg.norm(points, axis=2, keepdims=True)
    slope = np.zeros((*off.shape, points.shape[1]))
    for p, (a, b) in enumerate(pairs):
        slope[:, p, a] = (ray[:, a] * way[:, p]).sum(axis=1)
        slope[:, p, b] = -(ray[:, b] * way[:, p]).sum(axis=1)
    own = np.broadcast_to(np.eye(len(pairs)), (len(off), len(pairs), len(pairs)))  # medians are off with it
    A, y = np.concatenate([slope, own], axis=2).reshape(off.size, -1), off.ravel()
    left = y
    for _ in range(ROUNDS):
        scale = max(float(np.median(np.abs(left))), 1e-12)
        weight = 1 / np.sqrt(1 + (left / (CAUCHY * scale)) ** 2)
        found = np.linalg.lstsq(weight[:, None] * A, weight * y)[0]
        left = y - A @ found
    return np.asarray(left.reshape(off.shape))


def far_too_much(problem: Problem, error: Array) -> list[str]:
    """A remark, before any fit, where far more noise is stated than can be: more than the distances between
    targets scatter by, or than the nominal robot errs by. error: (M, 3) [m] of the nominal robot."""
    said = stated_noise(problem)
    if said is None or len(error) < FEWEST:
        return []
    shown = shown_by_distances(problem, said)
    nominal = float(np.median(np.linalg.norm(error, axis=1)) / np.sqrt(chdtri(3, 0.5)))
    ways = [(nominal, "the nominal robot errs by, uncalibrated,")]
    ways += [] if shown is None else [(shown.times * said.usual, "the distances between targets scatter by")]
    scatter, words = min(ways)
    times = said.usual / scatter
    if times < MANY:
        return []
    return [
        f"The stated noise of {1e3 * said.usual:.3g} mm per axis is {times:.0f} times what {words} "
        f"({1e3 * scatter:.2g} mm): is it in mm? Nothing smaller is looked for; state the instrument's own "
        "noise, or take it out."
    ]
