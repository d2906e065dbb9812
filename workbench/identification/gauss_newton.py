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
from .jacobian import Jacobian


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations of data rows J (N, D, P), r (N, D) and priors, in units of the priors and scaled."""

    J: Jacobian
    r: Array
    offset: Array
    prior: Array
    A: Array
    g: Array

    @classmethod
    def of(cls, J: Jacobian, r: Array, offset: Array, prior: Array) -> Normal:
        A, g = J.squares(r)
        A *= np.outer(prior, prior)
        A[np.diag_indices_from(A)] += 1.0
        return cls(J, r, offset, prior, A, g * prior - offset)

    def step(self, damping: float) -> Step:
        """By Cholesky; by QR where the equations are too nearly singular."""
        scale = 1 / np.sqrt(np.diag(self.A) + damping)
        M = (self.A + damping * np.eye(len(self.A))) * np.outer(scale, scale)
        try:
            step = scale * cho_solve(cho_factor(M, check_finite=False), scale * self.g)
        except np.linalg.LinAlgError:
            step = self._by_qr(damping)[0]
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
        return self._by_qr(0.0)[1]

    def _by_qr(self, damping: float) -> tuple[Array, Array]:
        """Step, in units of the priors, and triangular factor, by QR of the data's and the priors' rows."""
        P = len(self.prior)
        stacked = np.vstack([self.J.rows * self.prior, np.eye(P)])
        right = np.concatenate([self.r.ravel(), -self.offset])
        if damping > 0:
            stacked = np.vstack([stacked, np.sqrt(damping) * np.eye(P)])
            right = np.concatenate([right, np.zeros(P)])
        QtR, upper = _qr(stacked, right)
        return np.asarray(solve_triangular(upper, QtR)), upper

    def of_rows(self, r: Array) -> Normal:
        """The same for other rows r (N, D)."""
        return replace(self, r=r, g=self.J.onto(r) * self.prior - self.offset)

    def towards(self, r: Array) -> Normal:
        """The same for other rows r (N, D), without the pull of the priors."""
        return replace(self, offset=np.zeros_like(self.offset)).of_rows(r)


@dataclass(frozen=True, eq=False)
class Step:
    """change: (P,) of the fitted numbers; length: in standard deviations."""

    change: Array
    length: float


def _qr(A: Array, b: Array) -> tuple[Array, Array]:
    """Qᵀ b (P,) and R (P, P) of A = Q R, from one triangular factor of [A b]."""
    P = A.shape[1]
    factor = qr(np.column_stack([A, b]), mode="r", overwrite_a=True, check_finite=False)[0]
    R = np.asarray(factor, dtype=np.float64)
    return R[:P, P], R[:P, :P]
