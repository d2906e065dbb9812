"""Steps of Gauss and Newton, held by priors: by the normal equations where these will do, else by QR.

What hardly shows in the data is held by its prior alone, so damping (Levenberg's) counts in priors too:
scaled by the data's own columns it would stop just those numbers.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve, qr, solve_triangular

from ..robot.kinematics import Array


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations of data rows J (R, P), r (R,) and priors, in units of the priors and scaled."""

    J: Array
    r: Array
    offset: Array
    prior: Array
    A: Array
    g: Array

    @classmethod
    def of(cls, J: Array, r: Array, offset: Array, prior: Array) -> Normal:
        A = (J.T @ J) * np.outer(prior, prior)
        A[np.diag_indices_from(A)] += 1.0
        return cls(J, r, offset, prior, A, (J.T @ r) * prior - offset)

    def step(self, damping: float) -> Step:
        """By Cholesky; by QR where the equations are too nearly singular."""
        scale = 1 / np.sqrt(np.diag(self.A) + damping)
        M = (self.A + damping * np.eye(len(self.A))) * np.outer(scale, scale)
        try:
            step = scale * cho_solve(cho_factor(M, check_finite=False), scale * self.g)
        except np.linalg.LinAlgError:
            step = full_step(self.J, self.r, self.offset, self.prior, damping)[0] / self.prior
        return Step(step * self.prior, float(np.sqrt(max(float(step @ self.A @ step), 0.0))))

    def gain(self, change: Array) -> float:
        """What a change (P,) takes off the squares, to second order."""
        x = change / self.prior
        return float(x @ (2 * self.g - self.A @ x))

    def factor(self, rough: bool) -> Array:
        """Triangular factor (P, P) of the equations, by QR. rough: by Cholesky where that will do,
        quicker and good to some digits where they are nearly singular."""
        if rough:
            scale = np.sqrt(np.diag(self.A))
            with suppress(np.linalg.LinAlgError):
                return np.asarray(np.linalg.cholesky(self.A / np.outer(scale, scale)).T * scale)
        return full_step(self.J, self.r, self.offset, self.prior, 0.0)[1]

    def towards(self, r: Array) -> Normal:
        """The same for other rows r (R,), without the pull of the priors."""
        return replace(self, r=r, offset=np.zeros_like(self.offset), g=(self.J.T @ r) * self.prior)


@dataclass(frozen=True, eq=False)
class Step:
    """change: (P,) of the fitted numbers; length: in standard deviations."""

    change: Array
    length: float


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
