"""Residuals of poses that a fit did not see."""

from __future__ import annotations

import numpy as np

from ..robot.kinematics import Array
from .fit import Fit
from .rows import jacobian


def heldout(result: Fit, folds: int = 10, seed: int = 0) -> Array:
    """Residuals (N, T, 3) [m] of each pose by a fit that did not see it (NaN where not seen).

    Poses with equal joints and set-up (their loads, their repeats) stay together. The fits without a
    fold are Gauss–Newton steps from the full solution: exact to the second order of the change.
    """
    problem, cols = result.model.problem, result.columns
    block = problem.positions
    blocks = int(block.max()) + 1
    fold = (np.random.default_rng(seed).permutation(blocks) % min(folds, blocks))[block]
    plain = _motions(result)
    A = result.upper.T @ result.upper
    out = result.residual.copy()
    for f in range(fold.max() + 1):
        here = fold == f
        J = result.J[here].reshape(-1, len(cols.names)) * cols.prior
        r = result.r[here].ravel()
        left = A - J.T @ J
        left[np.diag_indices_from(left)] += 1e-12 * np.diag(A)
        change = np.linalg.solve(left, -(J.T @ r)) * cols.prior
        out[here] -= (plain[here] @ change)[:, : 3 * out.shape[1]].reshape(here.sum(), -1, 3)
    return out


def _motions(result: Fit) -> Array:
    """(N, R, P) Jacobian before whitening."""
    rows = result.whitener.shape[2]
    unit = np.broadcast_to(np.eye(rows), (len(result.whitener), rows, rows))
    return jacobian(result.model, result.line, result.columns, result.state, unit)
