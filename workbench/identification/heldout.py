"""Residuals of poses that a fit did not see."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .fit import Fit


def folds_of(problem: Problem, folds: int, seed: int) -> NDArray[np.int64]:
    """(N,) number of the group that each pose is held out with: joint positions drawn at random into groups
    of one size, so that a pose more or less leaves nearly all others where they were."""
    _, first, block = np.unique(problem.positions, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(problem.campaign.poses.drawn(seed)[first]))
    return np.asarray((rank * min(folds, len(first)) // len(first))[block.ravel()])


def heldout(result: Fit, folds: int = 10, seed: int = 0, without: Sequence[int] = ()) -> Array:
    """Residuals (N, T, 3) [m] of each pose by a fit that did not see it (NaN where not seen).

    Poses with equal joints and set-up (their loads, their repeats) stay together. without: numbers of the
    model's effects that are left out, everything else fitted anew. The fits are Gauss–Newton steps from the
    full solution: exact to the second order of the change.
    """
    problem, cols = result.model.problem, result.columns
    fold = folds_of(problem, folds, seed)
    plain = result.motions
    kept = np.ones(len(cols.names), bool)
    gone = np.zeros(len(cols.names))
    for i in without:
        kept[cols.effect[i]] = False
        gone[cols.effect[i]] = result.state.values[i]
    A = (result.upper.T @ result.upper)[np.ix_(kept, kept)]
    J = result.J * cols.prior
    lost = J @ (gone / cols.prior)
    r, J = result.r + lost, J[:, :, kept]
    out = result.residual + (plain @ gone)[:, : 3 * result.residual.shape[1]].reshape(result.residual.shape)
    slope = np.einsum("ndp,nd->p", J, lost)
    for f in range(fold.max() + 1):
        here = fold == f
        own = J[here].reshape(-1, J.shape[2])
        left = without_rows(A, own)
        change = np.zeros(len(cols.names))
        change[kept] = np.linalg.solve(left, slope - own.T @ r[here].ravel())
        change *= cols.prior
        out[here] -= (plain[here] @ change)[:, : 3 * out.shape[1]].reshape(here.sum(), -1, 3)
    return out


def without_rows(A: Array, own: Array) -> Array:
    """(P, P) normal equations A less those of the rows own (k, P)."""
    left = A - own.T @ own
    left[np.diag_indices_from(left)] += 1e-12 * np.diag(A)
    return np.asarray(left)
