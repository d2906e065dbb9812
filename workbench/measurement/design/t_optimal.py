"""Records that discriminate between rival causes: T-optimal for the pair that is hardest to tell.

λ, the T-criterion of Atkinson and Fedorov (1975), is the squared size of a cause, in standard deviations,
that frames, targets, geometry and the rival together cannot explain. With F their whitened rows and Y those
of the cause, in its typical size and averaged over the directions of its p parameters,

    λ = tr(YᵀY − YᵀF (K + FᵀF)⁻¹ FᵀY) / p

and a further record with rows F_x, Y_x adds exactly tr(Eᵀ S⁻¹ E)/p, with E = Y_x − F_x β the discrepancy of
the cause there from the best imitation so far, S = I + F_x V F_xᵀ, V = (K + FᵀF)⁻¹.
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
        return np.array([self.names.index(name) for name in parameter_names(effect)])

    @property
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
        left, out = self.left(data), []
        for effect, rival in pairs:
            i, j = self.columns(effect) - self.background, self.columns(rival) - self.background
            S = left[np.ix_(j, j)] + WIDE**-2 * np.eye(len(j))
            cross = left[np.ix_(j, i)]
            out.append((np.trace(left[np.ix_(i, i)]) - np.sum(cross * np.linalg.solve(S, cross))) / len(i))
        return np.maximum(out, 0.0)


def design_space(new: Sensitivity, before: Sensitivity | None) -> DesignSpace:
    """The candidates and the campaign on common parameters."""
    every = dict.fromkeys([*(before.names if before else ()), *new.names])
    names = tuple(sorted(every, key=lambda name: name.startswith("effect/")))
    was = np.zeros((len(names), len(names))) if before is None else information(before.on(names))
    return DesignSpace(names, new.on(names), was)


@dataclass(frozen=True)
class TCriterion:
    """λ of one cause beside one rival. F: (C, D, P) rows of background and rival, Y: (C, D, p) of the cause;
    K: (P, P) prior and measured information, c: (P, p) FᵀY and own: tr YᵀY of what was measured."""

    F: Array
    Y: Array
    K: Array
    c: Array
    own: float

    def with_each(self, rest: Records) -> Array:
        """(C,) λ of the plan `rest` with each candidate added."""
        P, p = self.c.shape
        F, Y = self.F[rest].reshape(-1, P), self.Y[rest].reshape(-1, p)
        V = np.linalg.inv(self.K + F.T @ F)
        c = self.c + F.T @ Y
        beta = V @ c
        value = self.own + float(np.sum(Y**2)) - float(np.sum(c * beta))
        S = np.matmul(self.F @ V, self.F.swapaxes(1, 2)) + np.eye(self.F.shape[1])
        E = self.Y - self.F @ beta
        gain = np.sum(E * np.linalg.solve(S, E), axis=(1, 2))
        return np.asarray((value + gain) / p)


def t_criterion(space: DesignSpace, pair: Pair) -> TCriterion:
    """The criterion of a pair, ready for the exchange."""
    cause, rival = pair
    i = space.columns(cause)
    f = np.concatenate([np.arange(space.background), space.columns(rival)])
    F, K = space.rows[:, :, f], space.before[np.ix_(f, f)]
    K = K + np.diag(prior_precision([space.names[k] for k in f]))
    scale = unit_scale(F, K)
    return TCriterion(
        F=F * scale,
        Y=space.rows[:, :, i],
        K=K * np.outer(scale, scale),
        c=space.before[np.ix_(f, i)] * scale[:, None],
        own=float(np.trace(space.before[np.ix_(i, i)])),
    )


def t_optimal(space: DesignSpace, pairs: Sequence[Pair], count: int, search: Search) -> Records:
    """`count` records with the largest λ of the hardest of these pairs. Those that are hard on average
    steer the exchange; what turns out harder then joins them, and the exchange goes on."""
    C = len(space.rows)
    average = space.before + count / C * information(space.rows)
    steering = [int(k) for k in np.argsort(space.criterion(average, pairs))[:STEERING]]
    criteria = [t_criterion(space, pairs[k]) for k in steering]

    def cost(rest: Records) -> Array:
        return np.asarray(-np.min([one.with_each(rest) for one in criteria], axis=0))

    chosen = fedorov.search(cost, C, count, search.starts, search.seed)
    while len(criteria) < MOST_STEERING:
        worst = int(np.argmin(space.criterion(space.measured(chosen), pairs)))
        if worst in steering:
            break
        steering.append(worst)
        criteria.append(t_criterion(space, pairs[worst]))
        chosen = fedorov.improve(cost, chosen)[1]
    return chosen
