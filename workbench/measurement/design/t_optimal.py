"""Records that discriminate between rival causes: T-optimal for the pair that is hardest to tell.

λ, the T-criterion of Atkinson and Fedorov (1975), is the squared size of a cause, in standard deviations,
that frames, targets, geometry and the rival together cannot explain, in its typical size and averaged over
the directions of its p parameters. With F the whitened rows of frames, targets and geometry, Y those of all
effects, and K what is known before, these leave of the effects

    L = YᵀY − YᵀF (K + FᵀF)⁻¹ FᵀY,    λ = tr(L_ii − L_ij (L_jj + 1/w²)⁻¹ L_ji) / p

of cause i beside rival j with prior w, and a further record with rows F_x, Y_x adds exactly Eᵀ S⁻¹ E to L,
with E = Y_x − F_x β the discrepancy of the effects there from the best imitation so far, S = I + F_x V F_xᵀ,
V = (K + FᵀF)⁻¹.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...effects.base import Effect
from ...robot.kinematics import Array
from . import fedorov
from .fedorov import Records, Search, information, unit_scale
from .prior_information import WIDE, Sensitivity, parameter_names, prior_precision

STEERING = 4  # criteria that steer the exchange at first, those of the hardest pairs
MOST_STEERING = 8

Pair = tuple[Effect, Effect]  # a cause and the rival that it must be told from


@dataclass(frozen=True)
class DesignSpace:
    """Candidate records and what was measured, on the background's parameters and those of all effects.

    names: (P,), those of the effects last; rows: (C, D, P); before: (P, P) information of the campaign.
    """

    names: tuple[str, ...]
    rows: Array
    before: Array

    def columns(self, effect: Effect) -> NDArray[np.int64]:
        """Columns of an effect's parameters."""
        if effect not in self._columns:
            self._columns[effect] = np.array([self.names.index(name) for name in parameter_names(effect)])
        return self._columns[effect]

    @cached_property
    def _columns(self) -> dict[Effect, NDArray[np.int64]]:
        """Those that were asked for."""
        return {}

    @cached_property
    def background(self) -> int:
        """Number of columns before the effects'."""
        return sum(not name.startswith("effect/") for name in self.names)

    def measured(self, chosen: Records, count: float | None = None) -> Array:
        """(P, P) information of the campaign and of some records; or of `count` in the proportions of these,
        each weighted alike (an approximate design: Fedorov 1972)."""
        times = 1.0 if count is None else count / len(chosen)
        return self.before + times * information(self.rows[chosen])

    @cached_property
    def everything(self) -> Array:
        """(P, P) information of the campaign and of all candidates."""
        return self.before + information(self.rows)

    @cached_property
    def left_of_everything(self) -> Array:
        """`left` of the campaign and of all candidates."""
        return self.left(self.everything)

    def left(self, data: Array) -> Array:
        """(g, g) information on the effects that frames, targets and geometry leave (Schur complement)."""
        b = self.background
        M = data + np.diag(np.where(np.arange(len(data)) < b, prior_precision(self.names), 0.0))
        scale = 1 / np.sqrt(np.diag(M)[:b])
        cross = M[:b, b:] * scale[:, None]
        return np.asarray(M[b:, b:] - cross.T @ np.linalg.solve(M[:b, :b] * np.outer(scale, scale), cross))

    def alone(self, data: Array, effect: Effect) -> float:
        """λ of an effect without any rival."""
        own = self.columns(effect) - self.background
        return float(self.left(data)[own, own].sum()) / len(own)

    def criterion(self, data: Array, pairs: Sequence[Pair]) -> Array:
        """λ of each cause beside its rival."""
        return self._of_pairs(self.left(data), pairs)

    def criterion_with_each(self, rest: Records, pairs: Sequence[Pair]) -> Array:
        """(len(pairs), C) λ of each cause beside its rival, of the plan `rest` with each candidate added."""
        effects = dict.fromkeys(effect for pair in pairs for effect in pair)
        own = np.unique(np.concatenate([self.columns(effect) for effect in effects])) - self.background
        return self._of_pairs(self._left_with_each(rest, own), pairs, own)

    def _of_pairs(self, left: Array, pairs: Sequence[Pair], own: NDArray[np.int64] | None = None) -> Array:
        """(len(pairs), ...) λ of each cause beside its rival, of what is `left` (..., g, g); own: the
        effects' columns that it is of, sorted, if not of all."""
        out = []
        for effect, rival in pairs:
            i, j = self.columns(effect) - self.background, self.columns(rival) - self.background
            if own is not None:
                i, j = np.searchsorted(own, i), np.searchsorted(own, j)
            S = left[..., j[:, None], j] + WIDE**-2 * np.eye(len(j))
            cross = left[..., j[:, None], i]
            alone = np.trace(left[..., i[:, None], i], axis1=-2, axis2=-1)
            out.append((alone - np.sum(cross * np.linalg.solve(S, cross), axis=(-2, -1))) / len(i))
        return np.maximum(out, 0.0)

    @cached_property
    def _by_part(self) -> tuple[Array, Array, Array, Array]:
        """Rows of the background F (C, D, b) and of the effects Y (C, D, g); prior and measured information K
        (b, b) and FᵀY of what was measured (b, g)."""
        b = self.background
        F, Y = self.rows[:, :, :b], self.rows[:, :, b:]
        K = self.before[:b, :b] + np.diag(prior_precision(self.names[:b]))
        scale = unit_scale(F, K)
        return F * scale, Y, K * np.outer(scale, scale), self.before[:b, b:] * scale[:, None]

    def _left_with_each(self, rest: Records, own: NDArray[np.int64]) -> Array:
        """(C, g, g) what is `left` of the plan `rest` with each candidate added; own: (g,) of which of the
        effects' columns."""
        F, Y, K, measured = self._by_part
        b = len(K)
        Y, measured, before = Y[:, :, own], measured[:, own], self.before[b + own[:, None], b + own]
        f, y = F[rest].reshape(-1, b), Y[rest].reshape(-1, Y.shape[2])
        V = np.linalg.inv(K + f.T @ f)
        c = measured + f.T @ y
        beta = V @ c
        left = before + y.T @ y - c.T @ beta
        flat = F.reshape(-1, b)  # one product of all, not one of each candidate
        S = np.matmul((flat @ V).reshape(F.shape), F.swapaxes(1, 2)) + np.eye(F.shape[1])
        E = Y - (flat @ beta).reshape(Y.shape)
        return np.asarray(left + np.matmul(E.swapaxes(1, 2), np.linalg.solve(S, E)))


def design_space(new: Sensitivity, before: Sensitivity | None) -> DesignSpace:
    """The candidates and the campaign on common parameters."""
    every = dict.fromkeys([*(before.names if before else ()), *new.names])
    names = tuple(sorted(every, key=lambda name: name.startswith("effect/")))
    was = np.zeros((len(names), len(names))) if before is None else information(before.on(names))
    return DesignSpace(names, new.on(names), was)


def t_optimal(space: DesignSpace, pairs: Sequence[Pair], count: int, search: Search) -> Records:
    """`count` records with the largest λ of the hardest of these pairs. Those that are hard on average
    steer the exchange; what turns out harder then joins them, and the exchange goes on."""
    C = len(space.rows)
    average = space.before + count / C * information(space.rows)
    steering = [int(k) for k in np.argsort(space.criterion(average, pairs))[:STEERING]]

    def cost(rest: Records) -> Array:
        return -space.criterion_with_each(rest, [pairs[k] for k in steering]).min(axis=0)

    chosen = fedorov.search(cost, C, count, search.starts, search.seed)
    while len(steering) < MOST_STEERING:
        worst = int(np.argmin(space.criterion(space.measured(chosen), pairs)))
        if worst in steering:
            break
        steering.append(worst)
        chosen = fedorov.improve(cost, chosen)[1]
    return chosen
