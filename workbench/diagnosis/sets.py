"""Which components together: the set of the highest posterior odds, and what could stand in its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..robot.kinematics import Array
from .components import Component
from .reduced import Index, Reduced
from .weight import Weight, weigh

MOST = 16
EXPLAINS = 1.0  # log Bayes factor from which a component explains anything at all


Shares = dict[int | None, float]


@dataclass(frozen=True)
class Member:
    component: int
    form: int
    scale: float


class Competition:
    """The search over sets of components at one linearisation."""

    def __init__(self, reduced: Reduced, components: Sequence[Component]) -> None:
        self.reduced, self.components = reduced, components

    def columns(self, members: Sequence[Member]) -> tuple[Index, Array]:
        """Columns of a set, and their prior precisions."""
        index = [np.arange(len(self.reduced.u))[self.reduced.parts[m.component][m.form]] for m in members]
        precision = [np.full(len(i), m.scale**-2) for i, m in zip(index, members, strict=True)]
        if not index:
            return np.zeros(0, int), np.zeros(0)
        return np.concatenate(index), np.concatenate(precision)

    def left_by(self, members: Sequence[Member]) -> Reduced:
        """What a set leaves of everything."""
        return self.reduced.given(*self.columns(members))

    def beside(self, members: Sequence[Member], among: Sequence[int] | None = None) -> dict[int, Weight]:
        """Weights of all other components beside a set."""
        chosen, precision = self.columns(members)
        left = self.reduced.given(chosen, precision)
        explained = self.reduced.explained(chosen, precision) if len(chosen) else 0.0
        taken = {m.component for m in members}
        every = range(len(self.components)) if among is None else among
        return {k: weigh(left, k, self.components[k], explained) for k in every if k not in taken}

    def best(self) -> list[Member]:
        """Greedy additions, then exchanges until none helps."""
        members: list[Member] = []
        while len(members) < MOST:
            weights = self.beside(members)
            if not weights:
                break
            k = max(weights, key=lambda i: weights[i].log_odds)
            if weights[k].log_odds <= 0:
                break
            members.append(Member(k, weights[k].form, weights[k].scale))
            members = self.exchanged(members)
        return members

    def exchanged(self, members: list[Member]) -> list[Member]:
        """Each member again, the others kept: in its best form, exchanged for a better one, or dropped."""
        for _ in range(3):
            before = list(members)
            for member in before:
                if member not in members:
                    continue
                rest = [m for m in members if m is not member]
                weights = self.beside(rest)
                k = max(weights, key=lambda i: weights[i].log_odds)
                own = weights[member.component].log_odds
                if max(weights[k].log_odds, own) <= 0:
                    members = rest
                    continue
                if weights[k].log_odds < own + 0.5:
                    k = member.component
                new = Member(k, weights[k].form, weights[k].scale)
                members[members.index(member)] = new
            if members == before:
                break
        return members

    def shares(self, members: Sequence[Member]) -> list[Shares]:
        """For each member: probability of it, of each stand-in, and of nothing (None) in its place."""
        out = []
        for member in members:
            weights = self.beside([m for m in members if m is not member])
            logs: Shares = {
                k: w.log_odds
                for k, w in weights.items()
                if k == member.component or w.log_odds - self.components[k].log_odds > EXPLAINS
            }
            logs[None] = 0.0
            top = max(logs.values())
            mass = {k: float(np.exp(v - top)) for k, v in logs.items()}
            total = sum(mass.values())
            out.append({k: v / total for k, v in mass.items()})
        return out
