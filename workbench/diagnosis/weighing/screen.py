"""Candidates in small matrices, with the background projected out (Frisch, Waugh, Lovell).

With G the candidates' whitened columns, e the whitened residual and V⁻¹ the projection that removes what
geometry, frames and targets can explain (within their priors): u = Gᵀ e, S = Gᵀ V⁻¹ G.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import chdtrc

from ...effects.base import Effect
from ...identification.fit import Fit
from ...robot.kinematics import Array
from .components import usual

SURVIVES = 1e-6  # share of a column's length² that the background must leave
FAINT = 1e-2  # length² (a λ) below which a typical size of a cause moves nothing worth a test


@dataclass(frozen=True)
class Shown:
    """What a background leaves of one candidate with p numbers. S: (p, p) in units where each number is
    counted in its usual size `scale` (p,); own: (p,) length² of its columns before projection."""

    S: Array
    own: Array
    scale: Array

    @property
    def rank(self) -> int:
        """Of what the background leaves; columns that move nothing drop out."""
        own = np.where(self.own > FAINT, self.own, np.inf)
        return quadratic(self.S, np.zeros(len(own)), own)[1]


def quadratic(S: Array, u: Array, own: Array) -> tuple[float, int]:
    """uᵀ S⁺ u and the rank of S; directions that the background swallowed do not count."""
    length = np.sqrt(own)
    scaled = S / (length[:, None] * length)
    if len(u) == 2:
        a, b, c = scaled[0, 0], scaled[1, 1], scaled[0, 1]
        det = a * b - c * c
        if det > SURVIVES * max(a + b, SURVIVES):
            x, y = u / length
            return float((x * x * b - 2 * x * y * c + y * y * a) / det), 2
    values, vectors = np.linalg.eigh(scaled)
    keep = values > SURVIVES
    if not keep.any():
        return 0.0, 0
    projected = (u / length) @ vectors[:, keep]
    return float(np.sum(projected**2 / values[keep])), int(keep.sum())


def reduce_columns(fit: Fit, G: Array) -> tuple[Array, Array, Array]:
    """S, u and own length² of whitened columns G: (N, D, g), the fit's own columns projected out."""
    flat = G.reshape(-1, G.shape[2])
    Z = along_own(fit, flat)
    gram = flat.T @ flat
    return gram - Z.T @ Z, flat.T @ fit.r.ravel() - Z.T @ still_to_go(fit), np.diag(gram).copy()


def along_own(fit: Fit, flat: Array) -> Array:
    """(P, g) what a fit's own numbers take of whitened columns (rows, g), through its factor: Zᵀ Z of their
    products."""
    across = (fit.normal.J.rows.T @ flat) * fit.columns.prior[:, None]
    return np.asarray(solve_triangular(fit.upper, across, trans="T", check_finite=False))


def still_to_go(fit: Fit) -> Array:
    """(P,) what the fit's own numbers would still take of the residual: next to nothing where it has
    converged. Of a rough fit it is not a candidate's, least of all of one that these numbers nearly are."""
    return np.asarray(solve_triangular(fit.upper, fit.normal.g, trans="T", check_finite=False))


def effective_dof(fit: Fit, drives: bool = False) -> float:
    """Rows of the points (and of the drive torques) minus what the fit took: the trace of V⁻¹."""
    rows = int((np.abs(fit.whitener).sum(axis=2) > 0).sum()) if drives else fit.point_rows
    inverse = solve_triangular(fit.upper, np.eye(len(fit.upper)), trans="T", check_finite=False)
    return rows - (len(fit.upper) - float((inverse**2).sum()))


def chance_of(fit: Fit, effect: Effect) -> float:
    """Probability that a function which does nothing takes as much off χ² beside a fit as this one does."""
    S, u, own = reduce_columns(fit, fit.whitened(effect))
    statistic, rank = quadratic(S, u, np.where(own > 0, own, np.inf))
    return float(chdtrc(rank, statistic)) if rank else 1.0


def shown(fit: Fit, effect: Effect) -> Shown:
    """What a fit leaves of a candidate by itself. Effects of the fit's model are background."""
    scale = usual(fit, effect)
    S, _, own = reduce_columns(fit, fit.whitened(effect) * scale)
    return Shown(S, own, scale)
