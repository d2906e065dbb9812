"""Records that tell rival causes apart: the largest λ of the pair that is hardest to tell.

λ of a cause beside its rival is the squared size, in standard deviations, of what frames, targets, geometry
and the rival together cannot explain of it. With F their whitened rows and Y those of the cause, in its
typical size and averaged over the directions of its p parameters,

    λ = tr(YᵀY − YᵀF (K + FᵀF)⁻¹ FᵀY) / p

and a further record with rows F_x, Y_x adds exactly tr(Eᵀ S⁻¹ E)/p, with E = Y_x − F_x β the discrepancy of
the cause there from the best imitation so far, S = I + F_x V F_xᵀ, V = (K + FᵀF)⁻¹.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...effects.base import Effect
from ...robot.kinematics import Array
from .fedorov import Records, improve, information, search, unit_scale
from .knowledge import WIDE, Rows, effect_names, information_before

STEERING = 4  # duels that steer the exchange at first, the hardest
MOST_STEERING = 8

Pair = tuple[Effect, Effect]  # a cause and the rival that it must be told from


@dataclass(frozen=True)
class Contest:
    """Candidate records and what was measured, on the background's parameters and those of all effects.

    names: (P,), those of the effects last; rows: (C, D, P); before: (P, P) information of the campaign.
    """

    names: tuple[str, ...]
    rows: Array
    before: Array

    def columns(self, effect: Effect) -> NDArray[np.int64]:
        """Columns of an effect's parameters."""
        return np.array([self.names.index(name) for name in effect_names(effect)])

    @property
    def background(self) -> int:
        """Number of columns before the effects'."""
        return sum(not name.startswith("effect/") for name in self.names)

    def data(self, chosen: Records) -> Array:
        """(P, P) information of the campaign and of some records."""
        return self.before + information(self.rows[chosen])

    def left(self, data: Array) -> Array:
        """(g, g) information on the effects that frames, targets and geometry leave (Schur complement)."""
        b = self.background
        M = data + np.diag(np.where(np.arange(len(data)) < b, information_before(self.names), 0.0))
        scale = 1 / np.sqrt(np.diag(M)[:b])
        cross = M[:b, b:] * scale[:, None]
        return np.asarray(M[b:, b:] - cross.T @ np.linalg.solve(M[:b, :b] * np.outer(scale, scale), cross))

    def alone(self, data: Array, effect: Effect) -> float:
        """λ of an effect without any rival."""
        own = self.columns(effect) - self.background
        return float(self.left(data)[own, own].sum()) / len(own)

    def lambdas(self, data: Array, pairs: Sequence[Pair]) -> Array:
        """λ of each cause beside its rival."""
        left, out = self.left(data), []
        for effect, rival in pairs:
            i, j = self.columns(effect) - self.background, self.columns(rival) - self.background
            S = left[np.ix_(j, j)] + WIDE**-2 * np.eye(len(j))
            cross = left[np.ix_(j, i)]
            out.append((np.trace(left[np.ix_(i, i)]) - np.sum(cross * np.linalg.solve(S, cross))) / len(i))
        return np.maximum(out, 0.0)


def contest(new: Rows, before: Rows | None) -> Contest:
    """Rows of the candidates and of the campaign on common parameters."""
    every = dict.fromkeys([*(before.names if before else ()), *new.names])
    names = tuple(sorted(every, key=lambda name: name.startswith("effect/")))
    was = np.zeros((len(names), len(names))) if before is None else information(before.on(names))
    return Contest(names, new.on(names), was)


@dataclass(frozen=True)
class Duel:
    """One cause beside one rival. F: (C, D, P) rows of background and rival, Y: (C, D, p) of the cause;
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
        gain = np.sum(np.linalg.inv(S) * np.matmul(E, E.swapaxes(1, 2)), axis=(1, 2))
        return np.asarray((value + gain) / p)


def duel(field: Contest, pair: Pair) -> Duel:
    """A pair of a contest, ready for the exchange."""
    i = field.columns(pair[0])
    f = np.concatenate([np.arange(field.background), field.columns(pair[1])])
    F, K = field.rows[:, :, f], field.before[np.ix_(f, f)]
    K = K + np.diag(information_before([field.names[k] for k in f]))
    scale = unit_scale(F, K)
    own = float(np.trace(field.before[np.ix_(i, i)]))
    return Duel(
        F * scale,
        field.rows[:, :, i],
        K * np.outer(scale, scale),
        field.before[np.ix_(f, i)] * scale[:, None],
        own,
    )


def tell_apart(field: Contest, pairs: Sequence[Pair], count: int, starts: int, seed: int) -> Records:
    """`count` records with the largest λ of the hardest of these pairs. Those that are hard on average
    steer the exchange; what turns out harder then joins them, and the exchange goes on."""
    C = len(field.rows)
    average = field.before + count / C * information(field.rows)
    steering = [int(k) for k in np.argsort(field.lambdas(average, pairs))[:STEERING]]
    duels = [duel(field, pairs[k]) for k in steering]

    def cost(rest: Records) -> Array:
        return np.asarray(-np.min([fight.with_each(rest) for fight in duels], axis=0))

    chosen = search(cost, C, count, starts, seed)
    while len(duels) < MOST_STEERING:
        worst = int(np.argmin(field.lambdas(field.data(chosen), pairs)))
        if worst in steering:
            break
        steering.append(worst)
        duels.append(duel(field, pairs[worst]))
        chosen = improve(cost, chosen)[1]
    return chosen
