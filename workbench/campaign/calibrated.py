"""Distances between calibrated targets: whether what was measured agrees with them, but for one scale."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from scipy.special import fdtrc

from ..robot.kinematics import Array
from .problem import Problem

FEWEST = 8  # poses that see both targets, from which the mean of their distance has a standard error
CHANCE = 1e-3  # that distances which are right, but for one scale, differ as much
FINEST = 1e-6  # m: no distance is calibrated better
SHOWN = 0.03  # of the best shown: a combination of distances that noise moves less, as of targets in a plane


def contradicted(problem: Problem) -> float | None:
    """[m] The largest difference of a measured distance between calibrated targets (`fixed`) of one body from
    the stated one, where these differ by more than chance and no one scale makes them; None elsewhere.

    A scale that distances show which do not agree on it is as uncertain as they disagree (Birge 1932): one
    that stands out of that as well is one."""
    every = [_of_body(problem, targets) for targets in _bodies(problem)]
    found = [one for one in every if one is not None]
    if not found:
        return None
    off, stated = (np.concatenate([one[k] for one in found]) for k in (0, 1))
    dof, poses = len(off) - 1, min(one[3] for one in found)
    free = poses - dof  # of Hotelling's T²: the covariance is the poses' own
    if dof < 1 or free < 1:
        return None
    gain = float(stated @ off) ** 2 / float(stated @ stated)
    disagree = max(float(off @ off) - gain, 1e-300) / dof
    if fdtrc(dof, free, disagree * free / (poses - 1)) > CHANCE or fdtrc(1, dof, gain / disagree) < CHANCE:
        return None
    return max(one[2] for one in found)


def _bodies(problem: Problem) -> Iterator[list[int]]:
    """The calibrated targets of each body that has several."""
    fixed = [i for i, target in enumerate(problem.campaign.targets) if target.fixed]
    for body in sorted({problem.on[i] for i in fixed}):
        mine = [i for i in fixed if problem.on[i] == body]
        if len(mine) > 1:
            yield mine


def _of_body(problem: Problem, targets: list[int]) -> tuple[Array, Array, float, int] | None:
    """What the distances between targets are off on average, and what a scale of 1 makes of them, whitened
    (K,) by how they scatter about that; the largest difference [m], and the number of poses. None where too
    few see all."""
    points = problem.campaign.points[:, targets]
    points = points[np.isfinite(points).all(axis=(1, 2))]
    if len(points) < FEWEST:
        return None
    a, b = np.array(list(combinations(range(len(targets)), 2))).T
    places = problem.stated_targets[targets]
    stated = np.linalg.norm(places[a] - places[b], axis=1)
    each = np.linalg.norm(points[:, a] - points[:, b], axis=2) - stated
    off = each.mean(axis=0)
    of_mean = np.atleast_2d(np.cov(each, rowvar=False)) / len(each)
    variance, axes = np.linalg.eigh(of_mean + FINEST**2 * np.eye(len(off)))
    kept = variance > SHOWN**2 * float(variance[-1])
    white = axes[:, kept] / np.sqrt(variance[kept])
    return off @ white, stated @ white, float(np.abs(off).max()), len(points)


def remarks(problem: Problem) -> list[str]:
    """A remark where calibrated targets are not where they are stated."""
    off = contradicted(problem)
    if off is None:
        return []
    return [
        f"The distances between calibrated targets (fixed = true) are up to {1e3 * off:.3f} mm off what is "
        "stated, and no scale makes them right. Look at their places, or take out `fixed`: what the fit "
        "leaves may be no more than that."
    ]
