"""Steps of Gauss and Newton, held by priors: by the normal equations where these will do, else by QR.

What hardly shows in the data is held by its prior alone, so damping (Levenberg's) counts in priors too:
scaled by the data's own columns it would stop just those numbers.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve, qr, solve_triangular

from ..robot.kinematics import Array


def quick_step(J: Array, r: Array, offset: Array, prior: Array, damping: float) -> tuple[Array, float]:
    """Step and its length in standard deviations, by the normal equations (scaled, then Cholesky);
    by QR where these are too nearly singular."""
    A = (J.T @ J) * np.outer(prior, prior)
    A[np.diag_indices_from(A)] += 1.0
    g = (J.T @ r) * prior - offset
    scale = 1 / np.sqrt(np.diag(A) + damping)
    M = (A + damping * np.eye(len(A))) * np.outer(scale, scale)
    try:
        step = scale * cho_solve(cho_factor(M, check_finite=False), scale * g)
    except np.linalg.LinAlgError:
        step = full_step(J, r, offset, prior, damping)[0] / prior
    return step * prior, float(np.sqrt(max(float(step @ A @ step), 0.0)))


def full_step(J: Array, r: Array, offset: Array, prior: Array, damping: float) -> tuple[Array, Array]:
    """Step of all numbers and the triangular factor, by QR of the data's and the priors' rows."""
    P = len(prior)
    stacked = np.vstack([J * prior, np.eye(P)])
    right = np.concatenate([r, -offset])
    if damping > 0:
        stacked = np.vstack([stacked, np.sqrt(damping) * np.eye(P)])
        right = np.concatenate([right, np.zeros(P)])
    QtR, upper = _qr(stacked, right)
    return np.asarray(solve_triangular(upper, QtR) * prior), upper


def _qr(A: Array, b: Array) -> tuple[Array, Array]:
    """Qᵀ b (P,) and R (P, P) of A = Q R, from one triangular factor of [A b]."""
    P = A.shape[1]
    factor = qr(np.column_stack([A, b]), mode="r", overwrite_a=True, check_finite=False)[0]
    R = np.asarray(factor, dtype=np.float64)
    return R[:P, P], R[:P, :P]
