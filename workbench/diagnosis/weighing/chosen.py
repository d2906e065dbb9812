"""A set of components in the reduced equations: what it explains, and what it leaves of everything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.linalg.blas import dtrmm
from scipy.linalg.lapack import dlauum, dtrtri
from scipy.sparse import csc_array

from ...robot.kinematics import Array
from .components import Component
from .reduced import Index, Reduced
from .weight import prior_weight

Shares = dict[int | None, float]


@dataclass(frozen=True)
class Member:
    component: int
    form: int
    scale: float


def columns_of(reduced: Reduced, member: Member) -> Index:
    """Numbers of a member's columns."""
    part = reduced.parts[member.component][member.form]
    return np.arange(part.start, part.stop)


class Chosen:
    """A set of members in the reduced equations: what it explains, and what it leaves of everything.

    With C the set's columns and P their prior precisions, M = (S_CC + P)⁻¹: left is S − S_C M S_Cᵀ. One
    member less gives back S_C M_m (M_mm)⁻¹ M_mᵀ S_Cᵀ: no need to solve again.
    """

    def __init__(self, reduced: Reduced, members: Sequence[Member]) -> None:
        self.reduced, self.members = reduced, tuple(members)
        self._back = dict[int, tuple[Array, Array]]()
        self._asked: tuple[Index | None, Array] = None, np.zeros(0)
        index = [columns_of(reduced, member) for member in members]
        self.index: Index = np.concatenate(index) if index else np.zeros(0, int)
        ends = np.cumsum([0, *(len(i) for i in index)])
        self.own = [slice(a, b) for a, b in pairwise(ends)]
        precision = [np.full(len(i), m.scale**-2) for i, m in zip(index, members, strict=True)]
        self.precision = np.concatenate(precision) if index else np.zeros(0)

    @cached_property
    def _upper(self) -> Array:
        """(c, c) triangular U with UᵀU = M⁻¹."""
        S = self.reduced.S.between(self.index, self.index) + np.diag(self.precision)
        return np.asarray(cholesky(S, check_finite=False))

    @cached_property
    def _half(self) -> Array:
        """(c, c) triangular H with H Hᵀ = M."""
        return np.asarray(dtrtri(self._upper)[0]) if len(self.index) else np.zeros((0, 0))

    @cached_property
    def inverse(self) -> Array:
        """(c, c) M."""
        if not len(self.index):
            return np.zeros((0, 0))
        upper = np.triu(dlauum(self._half)[0])
        return np.asarray(upper + np.triu(upper, 1).T)

    def _cross(self, index: Index) -> Array:
        """(F, p, c) of blocks of columns (F, p) with the set's own, the last ones asked for kept."""
        if self._asked[0] is not index:
            self._asked = index, self.reduced.S.between(index, self.index)
        return self._asked[1]

    @cached_property
    def beta(self) -> Array:
        u = self.reduced.u[self.index]
        if "inverse" in self.__dict__ or not len(u):
            return np.asarray(self.inverse @ u)
        return np.asarray(cho_solve((self._upper, False), u, check_finite=False))

    @cached_property
    def explained(self) -> float:
        """What the set takes off χ²."""
        return float(self.reduced.u[self.index] @ self.beta) if len(self.index) else 0.0

    def replaced(self, i: int, new: Member | None) -> Chosen:
        """The set without its i-th member and with a new one behind the others, by bordering: no need to
        invert again."""
        others = [member for j, member in enumerate(self.members) if j != i]
        rest = np.delete(np.arange(len(self.index)), self.own[i])
        across = self.inverse[rest][:, self.own[i]] @ self._given_back(i)[0]
        M = self.inverse[np.ix_(rest, rest)] - across @ across.T
        out = Chosen(self.reduced, others if new is None else [*others, new])
        if new is not None:
            own = out.index[out.own[-1]]
            beside = self.reduced.S.between(self.index[rest], own)
            T = M @ beside
            left = self.reduced.S.between(own, own) + np.diag(out.precision[out.own[-1]]) - beside.T @ T
            half = _half_inverse(left)
            T = T @ half
            M = np.block([[M + T @ T.T, -T @ half.T], [-half @ T.T, half @ half.T]])
        out.inverse = M
        return out

    def products_of(self, v: csc_array) -> Array:
        """(m, m) scalar products of what all columns (g,) make of what the set leaves, in m combinations
        v (g, m) of few each."""
        own, cross = self.reduced.S.combined(v, self.index)
        return np.asarray(own - cross @ self.inverse @ cross.T) if len(self.index) else own

    def left_of(
        self, index: NDArray[np.int64], without: int | NDArray[np.int64] | None = None
    ) -> tuple[Array, Array]:
        """S (F, p, p) and u (F, p) of blocks of columns (F, p) beside the set, or beside all but a member:
        one for all blocks, or one for each (F,)."""
        S = self.reduced.S.blocks(index)
        u = self.reduced.u[index]
        if not len(self.index):
            return S, u
        cross = self._cross(index)
        flat = cross.reshape(-1, len(self.index))
        u = u - cross @ self.beta
        if without is None:
            half = dtrmm(1.0, self._half, flat.T, trans_a=1).T.reshape(cross.shape)  # flat H
            S = S - half @ half.swapaxes(1, 2)
        else:
            K = (flat @ self.inverse).reshape(cross.shape)
            S = S - K @ cross.swapaxes(1, 2)
            each = np.broadcast_to(without, len(index))
            for member in np.unique(each).tolist():
                half, back = self._given_back(member)
                here = each == member
                Kh = K[here][:, :, self.own[member]] @ half
                S[here] += Kh @ Kh.swapaxes(1, 2)
                u[here] += Kh @ back
        return S, u

    def given_back(self, index: NDArray[np.int64], members: Sequence[int]) -> Array:
        """(F, p, M) what each member, left out of the set, gives back to u of blocks of columns (F, p)."""
        back = [self.inverse[:, self.own[i]] @ np.matmul(*self._given_back(i)) for i in members]
        return np.asarray(self._cross(index) @ np.stack(back, axis=1))

    def _given_back(self, member: int) -> tuple[Array, Array]:
        """Of a member H with H Hᵀ = (M_mm)⁻¹, and Hᵀ beta_m."""
        if member not in self._back:
            own = self.own[member]
            half = _half_inverse(self.inverse[own, own])
            self._back[member] = half, half.T @ self.beta[own]
        return self._back[member]

    def explained_without(self, member: int) -> float:
        """What the set but a member takes off χ²."""
        back = self._given_back(member)[1]
        return self.explained - float(back @ back)

    def price(self, i: int, component: Component) -> tuple[Array, float]:
        """S (p, p) that the other members leave of the i-th, of that component, and what its freedom and its
        prior cost, in χ²."""
        member, own = self.members[i], self.index[self.own[i]]
        S = self.left_of(own[None], i)[0][0]
        freedom = float(np.linalg.slogdet(np.eye(len(S)) + member.scale**2 * S)[1])
        return S, freedom - 2 * prior_weight(component, member.form, member.scale)

    @property
    def log_determinant(self) -> float:
        """log |1 + S P⁻¹|: what the set's freedom costs."""
        if not len(self.index):
            return 0.0
        return float(2 * np.log(np.diag(self._upper)).sum() - np.log(self.precision).sum())


def _half_inverse(A: Array) -> Array:
    """H with H Hᵀ = A⁻¹."""
    lower = np.linalg.cholesky(A)
    return np.asarray(solve_triangular(lower, np.eye(len(lower)), lower=True, check_finite=False).T)
