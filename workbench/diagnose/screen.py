"""Score tests of all candidates at once, with the background projected out (Frisch, Waugh, Lovell).

Everything happens in small matrices: with G the candidates' whitened columns, e the whitened residual
and V⁻¹ the projection that removes what geometry, frames and targets can explain (within their priors),

    u = Gᵀ e,   S = Gᵀ V⁻¹ G,   T_k = u_kᵀ S_kk⁺ u_k  ~  χ²(p_k)  where cause k is absent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.linalg import solve_triangular

from ..arm import Array
from ..effects.base import Effect
from ..fit import Fit

SURVIVES = 1e-6  # share of a column's length that the background must leave


@dataclass(frozen=True)
class Screen:
    """Candidates in reduced form. `parts[k]` are the columns of candidate k.

    S: (g, g), u: (g,) in units where every column's parameter is counted in its typical size;
    own: (g,) length² of the columns before projection; rss: whitened residual sum of squares, dof its
    degrees of freedom; known: the noise is known (χ²), else tests divide by the residual (F).
    """

    candidates: tuple[Effect, ...]
    parts: tuple[slice, ...]
    S: Array
    u: Array
    own: Array
    rss: float
    dof: float
    noise_dof: float
    known: bool
    scale: Array

    def statistic(self, k: Sequence[int], given: Sequence[int] = ()) -> tuple[float, int]:
        """Drop of the residual sum of squares by candidates `k` beyond `given`, and its rank."""
        g = self._columns(given)
        a = self._columns(k)
        S, u = self._without(a, g)
        return quadratic(S, u, self.own[a])

    def solution(self, k: Sequence[int]) -> tuple[Array, Array]:
        """Values of the candidates' parameters (their own units) and covariance, fitted together."""
        a = self._columns(k)
        inverse = np.linalg.pinv(self.S[np.ix_(a, a)], rcond=1e-10, hermitian=True)
        value = inverse @ self.u[a]
        return value * self.scale[a], inverse * np.outer(self.scale[a], self.scale[a])

    def p_value(self, statistic: float, rank: int, used: float = 0.0) -> float:
        """Tail probability of a statistic; `used`: what accepted causes took off the residual."""
        return p_value(statistic, rank, self.rss - used, self.dof, self.noise_dof, self.known)

    def _columns(self, k: Sequence[int]) -> Array:
        return np.concatenate([np.arange(len(self.u))[self.parts[i]] for i in k] or [np.zeros(0, int)])

    def _without(self, a: Array, g: Array) -> tuple[Array, Array]:
        S, u = self.S[np.ix_(a, a)], self.u[a]
        if len(g):
            cross = self.S[np.ix_(g, a)]
            solved = np.linalg.pinv(self.S[np.ix_(g, g)], rcond=1e-10, hermitian=True) @ np.column_stack(
                [cross, self.u[g]]
            )
            S, u = S - cross.T @ solved[:, :-1], u - cross.T @ solved[:, -1]
        return S, u


def quadratic(S: Array, u: Array, own: Array) -> tuple[float, int]:
    """uᵀ S⁺ u and the rank of S; directions that the background swallowed do not count."""
    length = np.sqrt(np.maximum(own, 1e-300))
    values, vectors = np.linalg.eigh(S / np.outer(length, length))
    keep = values > SURVIVES
    if not keep.any():
        return 0.0, 0
    projected = (u / length) @ vectors[:, keep]
    return float(np.sum(projected**2 / values[keep])), int(keep.sum())


def p_value(statistic: float, rank: int, rss: float, dof: float, noise_dof: float, known: bool) -> float:
    """χ² tail where the noise is known, F with the noise's own degrees of freedom where it is estimated."""
    if rank == 0:
        return 1.0
    if known and np.isinf(noise_dof):
        return float(stats.chi2.sf(statistic, rank))
    if known:
        return float(stats.f.sf(statistic / rank, rank, noise_dof))
    left = max(rss - statistic, 1e-12) / max(dof - rank, 1.0)
    return float(stats.f.sf(statistic / rank / left, rank, max(dof - rank, 1.0)))


def reduce_columns(fit: Fit, G: Array) -> tuple[Array, Array, Array]:
    """S, u and own length² of whitened columns G: (N, D, g), the fit's own columns projected out."""
    flat = G.reshape(-1, G.shape[2])
    J = fit.J.reshape(-1, fit.J.shape[2]) * fit.columns.prior
    Z = solve_triangular(fit.upper, J.T @ flat, trans="T", check_finite=False)
    gram = flat.T @ flat
    return gram - Z.T @ Z, flat.T @ fit.r.ravel(), np.diag(gram).copy()


def effective_dof(fit: Fit) -> float:
    """Rows of data minus what the fit took: the trace of the projection V⁻¹."""
    rows = int((np.abs(fit.whitener).sum(axis=2) > 0).sum())
    inverse = solve_triangular(fit.upper, np.eye(len(fit.upper)), trans="T", check_finite=False)
    return rows - (len(fit.upper) - float((inverse**2).sum()))


def screen(fit: Fit, candidates: Sequence[Effect], known: bool) -> Screen:
    """Reduced form of all candidates at a fit. Effects of the fit's model are background."""
    blocks, parts, scale, at = [], [], [], 0
    for effect in candidates:
        typical = np.array([p.typical for p in effect.params])
        G = fit.model.effect_jacobian(fit.line, effect, np.zeros(len(typical))) * typical
        blocks.append(G)
        parts.append(slice(at, at + len(typical)))
        scale.append(typical)
        at += len(typical)
    G = np.matmul(fit.whitener, np.concatenate(blocks, axis=2))
    S, u, own = reduce_columns(fit, G)
    return Screen(
        tuple(candidates),
        tuple(parts),
        S,
        u,
        own,
        fit.chi2,
        effective_dof(fit),
        fit.noise.dof,
        known,
        np.concatenate(scale),
    )
