"""Variances of what adds up to a scatter, by maximum likelihood."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from ..robot.kinematics import Array

EXACT, BEYOND = 1e-9, 100.0  # of the variance that one part would have alone: what is fitted lies between


def likeliest(d: Array, fixed: Array, parts: Sequence[Array], lost: float) -> tuple[Array, float]:
    """Variances (k,) of covariances that, beside a fixed one, add up to that of d (N, D), and the cost of
    them. fixed, parts: (D, D) or (N, D, D); lost: by how much a fit made the squares of d smaller."""

    def of_logarithms(x: Array) -> tuple[float, Array]:
        """The cost, and its gradient."""
        C = fixed + sum(v * part for v, part in zip(np.exp(x), parts, strict=True))
        inverse = np.linalg.inv(C)
        w = np.einsum("nij,nj->ni", inverse, d)
        slope = [
            v * (np.sum(inverse * part) - lost * float(np.einsum("ni,nij,nj->", w, part, w, optimize=True)))
            for v, part in zip(np.exp(x), parts, strict=True)
        ]
        return _cost(d, C, w, lost), np.array(slope)

    each = np.array([np.trace(part, axis1=-2, axis2=-1).sum() for part in parts])
    alone = np.log(float((d**2).sum()) / np.maximum(each, 1e-300))  # were it all there is
    bounds = [(one + np.log(EXACT), one + np.log(BEYOND)) for one in alone]
    found = minimize(of_logarithms, alone - np.log(len(parts)), jac=True, method="L-BFGS-B", bounds=bounds)
    return np.exp(found.x), float(found.fun)


def cost_of(d: Array, C: Array, lost: float) -> float:
    """Twice the negative log likelihood of d (N, D) under a covariance C (N, D, D), up to a constant."""
    w = np.asarray(np.linalg.solve(C, d[..., None])[..., 0], dtype=np.float64)
    return _cost(d, C, w, lost)


def _cost(d: Array, C: Array, w: Array, lost: float) -> float:
    return float(np.linalg.slogdet(C)[1].sum() + lost * np.sum(w * d))
