"""The search for the set of components with the highest posterior odds, and what could stand in for them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .acts_through import Needs
from .chosen import Chosen, Member, Shares
from .components import Component
from .reduced import Index, Reduced
from .stand_ins import StandIns
from .weight import Forms, Weight, likelihood, prior_weight

MOST = 24
EXPLAINS = 1.0  # log Bayes factor from which a component explains anything at all
EXCHANGES = 4  # rounds of them

Mask = NDArray[np.bool_]


class Competition:
    """The search over sets of components at one linearisation. needs: of a component, those beside which
    alone it competes."""

    def __init__(self, reduced: Reduced, components: Sequence[Component], needs: Needs | None = None) -> None:
        self.reduced, self.components, self.needs = reduced, components, needs or {}
        self.forms = Forms(reduced, components)

    def beside(
        self, chosen: Chosen, without: int | None = None, among: Mask | None = None
    ) -> dict[int, Weight]:
        """Weights of the other components beside a set, or beside all of it but one member."""
        taken = {m.component for i, m in enumerate(chosen.members) if i != without}
        allowed = np.ones(len(self.components), bool) if among is None else among.copy()
        allowed[list(taken)] = False
        for k, needed in self.needs.items():
            allowed[k] &= needed <= taken
        return self._weighed(chosen, without, allowed)

    def _weighed(self, chosen: Chosen, without: int | None, allowed: Mask) -> dict[int, Weight]:
        explained = chosen.explained if without is None else chosen.explained_without(without)
        return self.forms.weigh(lambda index: chosen.left_of(index, without), explained, allowed)

    def score(self, members: Sequence[Member]) -> float:
        """log posterior odds of a set against the empty one."""
        chosen = Chosen(self.reduced, members)
        gained = float(likelihood(self.reduced, 0.0, np.array(chosen.explained)))
        prior = sum(prior_weight(self.components[m.component], m.scale) for m in members)
        return gained - 0.5 * chosen.log_determinant + prior

    def best(self, before: Sequence[str] = ()) -> list[Member]:
        """The better of two searches: everything at once; or causes first, then everything. Where a set was
        found before (labels of its components), the search goes on from there. In the order of the
        components: two searches that end at one set are one, and what follows does not hang on rounding."""
        everything = np.ones(len(self.components), bool)
        if before:
            return self._in_order(self.search(self._again(before), everything))
        causes = np.array([not c.nameless for c in self.components])
        found = [self.search([], everything)]
        if causes.any() and not all(causes[m.component] for m in found[0]):
            found.append(self.search(self.search([], causes), everything))
        return max(map(self._in_order, found), key=self.score)

    @staticmethod
    def _in_order(members: list[Member]) -> list[Member]:
        return sorted(members, key=lambda member: member.component)

    def _again(self, labels: Sequence[str]) -> list[Member]:
        """The components with these labels, each in its likeliest form beside the others."""
        known = {component.label: k for k, component in enumerate(self.components)}
        here = [known[label] for label in labels if label in known]
        own = np.zeros(len(self.components), bool)
        own[here] = True
        weights = self._weighed(Chosen(self.reduced, []), None, own)
        members = [Member(k, weights[k].form, weights[k].scale) for k in here]
        return self.exchanged(members, own)

    def search(self, start: list[Member], among: Mask) -> list[Member]:
        """Additions while any helps, then exchanges, and again until neither does."""
        members = self.grown(list(start), among)
        for _ in range(EXCHANGES):
            better = self.exchanged(members, among)
            if better == members:
                break
            members = self.grown(better, among)
        return members

    def grown(self, members: list[Member], among: Mask) -> list[Member]:
        """The likeliest additions one by one, the members' own forms and scales kept up to date."""
        for _ in range(MOST):
            weights = self.beside(Chosen(self.reduced, members), among=among)
            k = max(weights, key=lambda i: weights[i].log_odds, default=None)
            if k is None or weights[k].log_odds <= 0:
                break
            members.append(Member(k, weights[k].form, weights[k].scale))
            own = np.zeros(len(self.components), bool)
            own[[m.component for m in members]] = True
            members = self.exchanged(members, own)
        return members

    def exchanged(self, members: list[Member], among: Mask) -> list[Member]:
        """Each member again, the others kept: in its best form, exchanged for a better one, or dropped."""
        about = self._columns(among)
        for _ in range(2):
            before = list(members)
            chosen = Chosen(self.reduced, members, about)
            for member in before:
                i = members.index(member)
                weights = self.beside(chosen, i, among)
                k = max(weights, key=lambda i: weights[i].log_odds, default=None)
                if k is None or weights[k].log_odds <= 0:
                    members = [m for m in members if m is not member]
                else:
                    own = weights.get(member.component)  # None: what it needs is gone
                    if own is not None and weights[k].log_odds < own.log_odds + 0.5:
                        k = member.component
                    new = Member(k, weights[k].form, weights[k].scale)
                    if new == member:
                        continue
                    members = [new if m is member else m for m in members]
                chosen = Chosen(self.reduced, members, about)
            if members == before:
                break
        return members

    def _columns(self, among: Mask) -> Index:
        """Of some components, in all their forms."""
        forms = [part for k in np.flatnonzero(among) for part in self.reduced.parts[k]]
        return np.concatenate([np.arange(part.start, part.stop) for part in forms] or [np.zeros(0, int)])

    def shares(self, members: Sequence[Member]) -> list[Shares]:
        """For each member: probability of it, of each stand-in, and of nothing (None) in its place.

        What would help beside the whole set as well stands in for nobody by that.
        """
        out = []
        chosen, stand_ins = Chosen(self.reduced, members), StandIns(self.reduced, self.components)
        anyway = {k: max(w.log_odds, 0.0) for k, w in self.beside(chosen).items()}
        for i, member in enumerate(members):
            weights = self.beside(chosen, i)
            if member.component not in weights:  # what it needs is gone
                out.append({member.component: 0.0, None: 1.0})
                continue
            logs: Shares = {}
            for k, w in weights.items():
                value = w.log_odds - anyway.get(k, 0.0)
                if k == member.component or value - self.components[k].log_odds > EXPLAINS:
                    logs[k] = value
            logs = stand_ins.believed(chosen, i, weights, logs)
            logs[None] = 0.0
            top = max(logs.values())
            mass = {k: float(np.exp(v - top)) for k, v in logs.items()}
            total = sum(mass.values())
            out.append({k: v / total for k, v in mass.items()})
        return out
