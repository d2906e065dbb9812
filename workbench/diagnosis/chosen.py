"""A set of components in the reduced equations: what it explains, and what it leaves of everything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from ..robot.kinematics import Array
from .components import Component
from .reduced import Index, Reduced
from .weight import prior_weight

Shares = dict[int | None, float]


@dataclass(frozen=True)
class Member:
    component: int
    form: int
    scale: float


class Chosen:
    """A set of members in the reduced equations: what it explains, and what it leaves of everything.

    With C the set's columns and P their prior precisions: K = S_C (S_CC + P)⁻¹, left S − K S_Cᵀ. One member
    less gives back K_m (M_mm)⁻¹ K_mᵀ, M = (S_CC + P)⁻¹: no need to solve again. about: columns that will be
    asked for; default: all.
    """

    def __init__(self, reduced: Reduced, members: Sequence[Member], about: Index | None = None) -> None:
        self.reduced, self.members = reduced, tuple(members)
        self._about = slice(None) if about is None else about
        self._back = dict[int, tuple[Array, Array]]()
        every = np.arange(len(reduced.u))
        index = [every[reduced.parts[m.component][m.form]] for m in members]
        self.index: Index = np.concatenate(index) if index else np.zeros(0, int)
        ends = np.cumsum([0, *(len(i) for i in index)])
        self.own = [slice(a, b) for a, b in pairwise(ends)]
        precision = [np.full(len(i), m.scale**-2) for i, m in zip(index, members, strict=True)]
        self.precision = np.concatenate(precision) if index else np.zeros(0)

    @cached_property
    def _factor(self) -> tuple[Array, bool]:
        S = self.reduced.S[np.ix_(self.index, self.index)] + np.diag(self.precision)
        return cho_factor(S, check_finite=False)

    @cached_property
    def inverse(self) -> Array:
        return np.asarray(cho_solve(self._factor, np.eye(len(self.index)), check_finite=False))

    @cached_property
    def cross(self) -> Array:
        """(g, c), zero but for the columns that will be asked for."""
        if isinstance(self._about, slice):
            return np.asarray(self.reduced.S[:, self.index])
        out = np.zeros((len(self.reduced.u), len(self.index)))
        out[self._about] = self.reduced.S[np.ix_(self._about, self.index)]
        return out

    @cached_property
    def K(self) -> Array:
        """(g, c), zero as `cross` is."""
        if isinstance(self._about, slice):
            return np.asarray(self.cross @ self.inverse)
        out = np.zeros(self.cross.shape)
        out[self._about] = self.cross[self._about] @ self.inverse
        return out

    @cached_property
    def beta(self) -> Array:
        return np.asarray(self.inverse @ self.reduced.u[self.index])

    @cached_property
    def explained(self) -> float:
        """What the set takes off χ²."""
        return float(self.reduced.u[self.index] @ self.beta) if len(self.index) else 0.0

    def left_of(self, index: NDArray[np.int64], without: int | None = None) -> tuple[Array, Array]:
        """S (F, p, p) and u (F, p) of blocks of columns (F, p) beside the set, or beside all but a member."""
        S = self.reduced.S[index[:, :, None], index[:, None, :]]
        u = self.reduced.u[index]
        if not len(self.index):
            return S, u
        K = self.K[index]
        S = S - K @ self.cross[index].swapaxes(1, 2)
        u = u - K @ self.reduced.u[self.index]
        if without is not None:
            half, back = self._given_back(without)
            Kh = K[:, :, self.own[without]] @ half
            S = S + Kh @ Kh.swapaxes(1, 2)
            u = u + Kh @ back
        return S, u

    def _given_back(self, member: int) -> tuple[Array, Array]:
        """Of a member H with H Hᵀ = (M_mm)⁻¹, and Hᵀ beta_m."""
        if member not in self._back:
            own = self.own[member]
            lower = np.linalg.cholesky(self.inverse[own, own])
            half = solve_triangular(lower, np.eye(len(lower)), lower=True, check_finite=False).T
            self._back[member] = half, half.T @ self.beta[own]
        return self._back[member]

    def explained_without(self, member: int) -> float:
        back = self._given_back(member)[1]
        return self.explained - float(back @ back)

    def price(self, i: int, component: Component) -> tuple[Array, float]:
        """S (p, p) that the other members leave of the i-th, of that component, and what its freedom and its
        prior cost, in χ²."""
        member, own = self.members[i], self.index[self.own[i]]
        S = self.left_of(own[None], i)[0][0]
        freedom = float(np.linalg.slogdet(np.eye(len(S)) + member.scale**2 * S)[1])
        return S, freedom - 2 * prior_weight(component, member.scale)

    @property
    def log_determinant(self) -> float:
        """log |1 + S P⁻¹|: what the set's freedom costs."""
        if not len(self.index):
            return 0.0
        diagonal = np.diag(self._factor[0])
        return float(2 * np.log(np.abs(diagonal)).sum() - np.log(self.precision).sum())
