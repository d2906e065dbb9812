"""Score tests of all candidates at once, with the background projected out (Frisch, Waugh, Lovell).

Everything happens in small matrices: with G the candidates' whitened columns, e the whitened residual
and V⁻¹ the projection that removes what geometry, frames and targets can explain (within their priors),

    u = Gᵀ e,   S = Gᵀ V⁻¹ G,   T_k = u_kᵀ S_kk⁺ u_k  ~  χ²(p_k)  where cause k is absent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from ..effects.base import Effect
from ..identification.fit import Fit
from ..robot.kinematics import Array

SURVIVES = 1e-6  # share of a column's length² that the background must leave
FAINT = 1e-2  # length² (a λ) below which a typical size of a cause moves nothing worth a test


@dataclass(frozen=True)
class Screen:
    """Candidates in reduced form. `parts[k]` are the columns of candidate k.

    S: (g, g), u: (g,) in units where every column's parameter is counted in its typical size;
    own: (g,) length² of the columns before projection; held: (g,) what the parameters' priors add to the
    diagonal of S where several are solved for; rss: whitened residual sum of squares, dof its
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
    held: Array

    def statistic(self, k: Sequence[int], given: Sequence[int] = ()) -> tuple[float, int]:
        """Drop of the residual sum of squares by candidates `k` beyond `given`, and its rank."""
        g = self.columns(given)
        a = self.columns(k)
        S, u = self._without(a, g)
        return quadratic(S, u, self._size(a))

    def _size(self, index: NDArray[np.int64]) -> Array:
        """Length² of columns; infinite for those that move nothing, so that they drop out."""
        return np.where(self.own[index] > FAINT, self.own[index], np.inf)

    def _solve(self, g: NDArray[np.int64], right: Array) -> Array:
        """S_gg⁻¹ right, held by the priors, with a whiff of ridge for sets that are nearly dependent."""
        if not len(g):
            return np.zeros((0, *right.shape[1:]))
        S = self.S[np.ix_(g, g)].copy()
        S[np.diag_indices_from(S)] += 1e-10 * self.own[g] + self.held[g]
        return np.asarray(np.linalg.solve(S, right), dtype=np.float64)

    def columns(self, k: Sequence[int]) -> NDArray[np.int64]:
        """Numbers of the columns of some candidates."""
        return np.concatenate([np.arange(len(self.u))[self.parts[i]] for i in k] or [np.zeros(0, int)])

    def _without(self, a: NDArray[np.int64], g: NDArray[np.int64]) -> tuple[Array, Array]:
        S, u = self.S[np.ix_(a, a)], self.u[a]
        if len(g):
            cross = self.S[np.ix_(g, a)]
            solved = self._solve(g, np.column_stack([cross, self.u[g]]))
            S, u = S - cross.T @ solved[:, :-1], u - cross.T @ solved[:, -1]
        return S, u


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
    J = fit.J.reshape(-1, fit.J.shape[2]) * fit.columns.prior
    Z = solve_triangular(fit.upper, J.T @ flat, trans="T", check_finite=False)
    gram = flat.T @ flat
    return gram - Z.T @ Z, flat.T @ fit.r.ravel(), np.diag(gram).copy()


def effective_dof(fit: Fit, drives: bool = False) -> float:
    """Rows of the points (and of the drive torques) minus what the fit took: the trace of V⁻¹."""
    rows = int((np.abs(fit.whitener).sum(axis=2) > 0).sum()) if drives else fit.point_rows
    inverse = solve_triangular(fit.upper, np.eye(len(fit.upper)), trans="T", check_finite=False)
    return rows - (len(fit.upper) - float((inverse**2).sum()))


def screen(fit: Fit, candidates: Sequence[Effect], known: bool) -> Screen:
    """Reduced form of all candidates at a fit. Effects of the fit's model are background."""
    blocks, parts, scale, held, at = [], [], [], [], 0
    for effect in candidates:
        typical = np.array([p.typical for p in effect.params])
        G = fit.model.effect_jacobian(fit.line, effect, np.zeros(len(typical))) * typical
        blocks.append(G)
        parts.append(slice(at, at + len(typical)))
        scale.append(typical)
        held += ((typical / effect.prior(fit.model.problem)) ** 2).tolist()
        at += len(typical)
    G = np.matmul(fit.whitener, np.concatenate(blocks, axis=2))
    S, u, own = reduce_columns(fit, G)
    return Screen(
        tuple(candidates),
        tuple(parts),
        S,
        u,
        own,
        float((fit.r**2).sum()),
        effective_dof(fit, drives=True),
        fit.noise.dof,
        known,
        np.concatenate(scale),
        np.array(held),
    )
