"""The search over changes, several of which may be of one quantity: its course is weighed as a whole."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..weighing.chosen import Chosen, Member
from ..weighing.reduced import Reduced
from ..weighing.sets import CLEARLY, EXCHANGES, Competition, Mask
from .candidates import Candidate


class Search(Competition):
    """The competition of candidates. Events of one quantity are found one by one, and what the first of them
    are not quite, others stand in for: no single exchange leads from there to the course that it took."""

    def __init__(self, reduced: Reduced, candidates: Sequence[Candidate]) -> None:
        super().__init__(reduced, [candidate.component for candidate in candidates])
        self.candidates = candidates

    def _settled(self, members: list[Member]) -> list[Member]:
        members = super()._settled(members)
        for _ in range(EXCHANGES):
            better = self._other_course(members)
            if better is None:
                break
            members = super()._settled(better)
        return members

    def _other_course(self, members: Sequence[Member]) -> list[Member] | None:
        """A set that is found when a quantity begins again, if clearly likelier."""
        now, everything = self.score(members), np.ones(len(self.components), bool)
        every = [self.candidates[m.component] for m in members]
        for quantity in dict.fromkeys(one.quantity for one in every if one.change):
            others = [m for m, one in zip(members, every, strict=True) if one.quantity != quantity]
            own = np.array([candidate.quantity == quantity for candidate in self.candidates])
            for start in self._begun_again(others, own):
                new = self.search(start, everything)
                if self.score(new) > now + CLEARLY:
                    return new
        return None

    def _begun_again(self, others: Sequence[Member], own: Mask) -> Iterator[list[Member]]:
        """The other members; and beside them any course of a quantity (its candidates), without what that
        makes superfluous."""
        yield [*others]
        for k in np.flatnonzero(own).tolist():
            if self.candidates[k].any_course:
                (weight,) = self.forms.weigh(Chosen(self.reduced, others), [k])
                among = ~own
                among[k] = True
                yield self.search([*others, Member(k, weight.form, weight.scale)], among)
