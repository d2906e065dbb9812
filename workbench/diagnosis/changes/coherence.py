"""How much alike what the model leaves is in neighbouring postures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.stats import chi2

from ...identification.fit import Fit
from ...robot.kinematics import Array

NEAR = 16  # poses at most that are neighbours
SURE = 0.95


def coherence(fit: Fit) -> float:
    """0 to 1: correlation between neighbouring poses of what the model leaves, as far as it looks like a
    number of the geometry that is otherwise there (intraclass correlation: Kish 1965); the most that it may
    be, with 95 %, by as many groups of neighbours as there are.

    Each group is predicted by all others, and what it misses by is made white as if poses were independent:
    along a number of the geometry that has the variance of all else, or as many times it as the group's
    poses are alike.
    """
    n = fit.J.shape[2]
    groups = list(neighbours(fit.model.problem.q, np.arange(len(fit.J))))
    if len(groups) < 2:  # none is predicted by another
        return 1.0
    J, own = fit.J * fit.columns.prior, fit.columns.geometry_slice
    upper = np.linalg.qr(np.vstack([J.reshape(-1, n), np.eye(n)]), mode="r")
    along, every, count = 0.0, 0.0, 0.0
    rows, numbers = 0, 0
    for group in groups:
        G = J[group].reshape(-1, n)
        half = solve_triangular(upper, G.T, trans="T", check_finite=False)
        held, axes = np.linalg.eigh(np.eye(len(G)) - half.T @ half)
        left = axes @ ((axes.T @ fit.r[group].ravel()) / np.sqrt(np.maximum(held, 1e-6)))
        lengths = np.linalg.norm(G[:, own], axis=0)
        shown = lengths > 1e-6 * lengths.max()
        along += float((((G[:, own].T @ left)[shown] / lengths[shown]) ** 2).sum())
        every += float(left @ left)
        numbers += int(shown.sum())
        rows += int((np.abs(fit.whitener[group]).sum(axis=2) > 0).sum())
        count += len(group) * int(shown.sum())
    together = (along / numbers) / (every / rows) * len(groups) / float(chi2.isf(SURE, len(groups)))
    return float(np.clip((together - 1) / (count / numbers - 1), 0.0, 1.0))


def neighbours(q: Array, poses: NDArray[np.int64], most: int = NEAR) -> Iterator[NDArray[np.int64]]:
    """Groups of poses near each other, `most` at most: halved where the joints (N, n) are farthest apart."""
    if len(poses) <= most:
        yield poses
        return
    j = int(np.argmax(np.std(q[poses], axis=0) / np.maximum(np.ptp(q, axis=0), 1e-9)))
    order = poses[np.argsort(q[poses, j], kind="stable")]
    yield from neighbours(q, order[: len(order) // 2], most)
    yield from neighbours(q, order[len(order) // 2 :], most)
