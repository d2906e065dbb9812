"""The search for the set of components with the highest posterior odds, and what could stand in for them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from .acts_through import Needs
from .chosen import Chosen, Member, Shares
from .components import Component
from .forms import Forms
from .reduced import Reduced
from .stand_ins import StandIns
from .weight import Weight, likelihood, prior_weight

MOST = 24
EXPLAINS = 1.0  # log Bayes factor from which a component explains anything at all
EXCHANGES = 4  # rounds of them
AT_ONCE = 4  # members that are weighed together: of as many, one changes
STRONGEST, PAIRS = 6, 3  # members in the place of which two are tried, and how many such pairs
ABOUT, SHARE = 12.0, 0.02  # log odds that the estimate of a pair's may be off, and of those that it has
WEAKEST = 3  # members without which another may be likelier in another's place
CLEARLY = 0.5  # log odds by which another component must be likelier to take a member's place

Mask = NDArray[np.bool_]


class Competition:
    """The search over sets of components at one linearisation. needs: of a component, those beside which
    alone it competes."""

    def __init__(self, reduced: Reduced, components: Sequence[Component], needs: Needs | None = None) -> None:
        self.reduced, self.components, self.needs = reduced, components, needs or {}
        self.forms = Forms(reduced, components)
        self.certain = frozenset(k for k, component in enumerate(components) if component.certain)
        self._either = {
            k: {i for i, other in enumerate(components) if i != k and other.key[0] == component.key[0]}
            for k, component in enumerate(components)
            if component.alike
        }  # what is alike in all joints, or off in some: not both

    def beside(
        self, chosen: Chosen, without: int | None = None, among: Mask | None = None
    ) -> dict[int, Weight]:
        """Weights of the other components beside a set, or beside all of it but one member."""
        return self._weights(chosen, self._open(chosen, without, among), without)

    def _weights(self, chosen: Chosen, numbers: Sequence[int], without: int | None) -> dict[int, Weight]:
        """Of components by their numbers, beside a set, or beside all of it but one member."""
        gone = None if without is None else np.full(len(numbers), without)
        return dict(zip(numbers, self.forms.weigh(chosen, numbers, gone), strict=True))

    def _open(self, chosen: Chosen, without: int | None, among: Mask | None) -> list[int]:
        """Components that may stand beside a set, or beside all of it but one member."""
        taken = {m.component for i, m in enumerate(chosen.members) if i != without}
        allowed = np.ones(len(self.components), bool) if among is None else among.copy()
        allowed[list(taken)] = False
        for k, needed in self.needs.items():
            allowed[k] &= needed <= taken
        for k, parts in self._either.items():
            allowed[list(parts)] &= k not in taken
            allowed[k] &= not parts & taken
        return [int(k) for k in np.flatnonzero(allowed)]

    def score(self, members: Sequence[Member]) -> float:
        """log posterior odds of a set against the empty one."""
        chosen = Chosen(self.reduced, members)
        return float(likelihood(self.reduced, 0.0, np.array(chosen.explained))) + self.cost(chosen)

    def cost(self, chosen: Chosen) -> float:
        """log odds of a set before the data, and what its freedom costs."""
        prior = sum(prior_weight(self.components[m.component], m.form, m.scale) for m in chosen.members)
        return float(prior - 0.5 * chosen.log_determinant)

    def best(self, before: Sequence[str] = ()) -> list[Member]:
        """The best of several searches: everything at once; causes first, then everything; what yields
        first, which one load hardly tells from heavier masses and stiffer joints elsewhere: where such loads
        were found, or what is alike in all joints, without the latter too. Where a set was found before
        (labels of its components), the search goes on from there. In the order of the components: two
        searches that end at one set are one, and what follows does not hang on rounding.
        What is certain to be there is in every set, and left out at the end where it shows nothing."""
        everything = np.ones(len(self.components), bool)
        causes = np.array([not c.nameless or c.certain for c in self.components], bool)
        apart = np.array([k not in self._either for k in range(len(self.components))], bool)
        yields = np.array([c.yields or c.certain for c in self.components], bool)
        there = self._again([])
        found = [self.search(self._again(before) if before else there, everything)]
        for some in () if before else (causes, yields):
            if not all(some[m.component] for m in found[0]) and (begun := self.search(there, some)) != there:
                found.append(self.search(begun, everything))
        alike = any(m.component in self._either for members in found for m in members)
        loads = any(self.components[m.component].loads for members in found for m in members)
        if alike or (loads and not before):
            found.append(self.search(self.search(there, yields & apart), everything))
        if alike and not before:
            found.append(self.search(self.search(there, apart), everything))
        return self._showing(self._settled(max(map(self._in_order, found), key=self.score)))

    def _showing(self, members: list[Member]) -> list[Member]:
        """A set in the order of its components, without what is certain, but too small to show."""
        while there := [i for i, member in enumerate(members) if member.component in self.certain]:
            chosen = Chosen(self.reduced, members)
            own = self.forms.weigh(chosen, [members[i].component for i in there], np.array(there))
            least = min(range(len(there)), key=lambda n: own[n].log_odds)
            if own[least].log_odds > 0:
                break
            del members[there[least]]
        return self._in_order(members)

    def _settled(self, members: list[Member]) -> list[Member]:
        """A set in which no two components are likelier in the place of one, no one in the place of two, and
        not some joints in the place of all alike, nor these in theirs: else the search goes on."""
        everything = np.ones(len(self.components), bool)
        for _ in range(EXCHANGES):
            better = self.split(members) or self.merged(members) or self._clearly_otherwise(members)
            if better is None:
                break
            before, members = members, self.search(better, everything)
            if {m.component for m in members} == {m.component for m in before}:
                break
        return members

    def merged(self, members: Sequence[Member]) -> list[Member] | None:
        """The set without one of its members that add little, the others exchanged, where that is likelier;
        None where it is not. What two causes do together, neither of them quite, another may do alone."""
        now, everything = self.score(members), np.ones(len(self.components), bool)
        without = [
            [*members[:i], *members[i + 1 :]]
            for i, member in enumerate(members)
            if member.component not in self.certain
        ]
        for others in sorted(without, key=self.score, reverse=True)[:WEAKEST]:
            new = self.exchanged(others, everything)
            if self.score(new) > now + CLEARLY:
                return new
        return None

    def split(self, members: Sequence[Member]) -> list[Member] | None:
        """The set with two components in the place of one of its strongest members, where that is likelier;
        None where it is not. What one cause does roughly, two may do truly, though neither does it alone."""
        now = self.score(members)
        for i in self._strongest(Chosen(self.reduced, members)):
            for _, new in self._in_its_place(members, i):
                if self.score(new) > now + CLEARLY:
                    return new
        return None

    def _strongest(self, chosen: Chosen) -> list[int]:
        """The members that take most off χ², without what is certain to be there."""
        takes = [chosen.explained - chosen.explained_without(i) for i in range(len(chosen.members))]
        first = np.argsort(takes)[: -STRONGEST - 1 : -1].tolist()
        return [i for i in first if chosen.members[i].component not in self.certain]

    def _in_its_place(
        self, members: Sequence[Member], i: int
    ) -> Iterator[tuple[tuple[Member, Member], list[Member]]]:
        """Pairs that may stand in a member's place, each with the set that then is likeliest."""
        others = [member for j, member in enumerate(members) if j != i]
        rest = Chosen(self.reduced, others)
        if members[i].component in self._open(rest, None, None):  # what it needs is there
            for pair in self._pairs(rest, members[i]):
                yield pair, self.exchanged([*others, *pair], self._only(*others, *pair))

    def _pairs(self, rest: Chosen, instead_of: Member) -> Iterator[tuple[Member, Member]]:
        """The likeliest pairs beside a set, if about as likely as a member was. Of each two the evidence
        together counts, and what the prior and the freedom of each cost by itself."""
        weights = self.beside(rest)
        own = weights.pop(instead_of.component).log_odds
        least = own - max(ABOUT, SHARE * own)  # the forms of a pair are others than those of each alone
        if len(weights) < 2:
            return
        alone = [Member(k, weight.form, weight.scale) for k, weight in weights.items()]
        q, both = self.forms.together(rest, alone)
        paid = np.array([w.log_odds for w in weights.values()]) - likelihood(self.reduced, rest.explained, q)
        odds = likelihood(self.reduced, rest.explained, both) + paid[:, None] + paid
        odds[np.tril_indices(len(odds))] = -np.inf
        first, second = np.nonzero(odds > least)
        for at in np.argsort(odds[first, second])[: -PAIRS - 1 : -1]:
            yield alone[first[at]], alone[second[at]]

    def _two_causes(self, members: Sequence[Member], i: int) -> Iterator[tuple[int, float]]:
        """Of two causes in the place of a member the first, and how much likelier than its own the set with
        them is (log): what several springs do together one elsewhere may do nearly."""
        own, now = self.components[members[i].component], self.score(members)
        if own.nameless:
            return
        for pair, new in self._in_its_place(members, i):
            there = {member.component for member in new}
            two = [member.component for member in pair]
            if there >= {*two} and not any(self.components[k].nameless for k in two):
                yield two[0], min(self.score(new) - now, 0.0)

    def _otherwise(self, members: Sequence[Member]) -> Iterator[tuple[dict[int, int], list[Member]]]:
        """Sets with what is alike in all joints instead of several that have it, or several instead of all
        alike; and of the members that this is about what would then be in their places."""
        for k, parts in self._either.items():
            own = [m.component for m in members if m.component == k or m.component in parts]
            if not own or (len(own) == 1 and own != [k]):
                continue
            others = [m for m in members if m.component not in own]
            among = self._only(*others)
            among[list(parts) if own == [k] else k] = True
            new = self.search(others, among)
            instead = [i for i, m in enumerate(new) if m.component not in {o.component for o in others}]
            if instead:
                chosen = Chosen(self.reduced, new)
                first = min(instead, key=chosen.explained_without)
                yield dict.fromkeys(own, new[first].component), new

    def _clearly_otherwise(self, members: Sequence[Member]) -> list[Member] | None:
        """The set as `_otherwise` has it, where that is likelier; None where it is not."""
        now = self.score(members) + CLEARLY
        return next((new for _, new in self._otherwise(members) if self.score(new) > now), None)

    @staticmethod
    def _in_order(members: list[Member]) -> list[Member]:
        return sorted(members, key=lambda member: member.component)

    def _again(self, labels: Sequence[str]) -> list[Member]:
        """The components with these labels, and those that are certain, each in its likeliest form
        beside the others."""
        known = {component.label: k for k, component in enumerate(self.components)} if labels else {}
        here = list(dict.fromkeys([*sorted(self.certain), *(known[one] for one in labels if one in known)]))
        weights = self.forms.weigh(Chosen(self.reduced, []), here)
        members = [Member(k, weight.form, weight.scale) for k, weight in zip(here, weights, strict=True)]
        return self.exchanged(members, self._only(*members))

    def _only(self, *members: Member) -> Mask:
        """The members' own components and no others."""
        own = np.zeros(len(self.components), bool)
        own[[member.component for member in members]] = True
        return own

    def search(self, start: list[Member], among: Mask) -> list[Member]:
        """Additions while any helps, then exchanges, again and again while these make it clearly likelier."""
        members = self.grown(list(start), among)
        for _ in range(EXCHANGES):
            better = self.exchanged(members, among)
            if better == members or self.score(better) < self.score(members) + CLEARLY:
                return better
            members = self.grown(better, among)
        return members

    def grown(self, members: list[Member], among: Mask) -> list[Member]:
        """The likeliest additions one by one, the members' own forms and scales kept up to date. Where an
        addition drives out what comes back for it, the sets go round: then the likeliest of them."""
        sets = [members]
        while len(sets) <= MOST:
            weights = self.beside(Chosen(self.reduced, members), among=among)
            k = max(weights, key=lambda i: weights[i].log_odds, default=None)
            if k is None or weights[k].log_odds <= 0:
                return members
            added = [*members, Member(k, weights[k].form, weights[k].scale)]
            members = self.exchanged(added, self._only(*added))
            numbers = {m.component for m in members}
            again = [i for i, one in enumerate(sets) if {m.component for m in one} == numbers]
            if again:
                return max(sets[again[-1] :], key=self.score)
            sets.append(members)
        return members

    def exchanged(self, members: list[Member], among: Mask) -> list[Member]:
        """Each member again, the others kept: in its best form, exchanged for a better one, or dropped."""
        for _ in range(2):
            before, still = list(members), list(members)
            chosen = Chosen(self.reduced, members)
            while still:
                change = self._first_change(chosen, still, among)
                if change is None:
                    break
                member, new = change
                chosen = chosen.replaced(chosen.members.index(member), new)
                still = still[still.index(member) + 1 :]
                at = members.index(member)
                members = [*members[:at], *([] if new is None else [new]), *members[at + 1 :]]
            if members == before:
                break
        return members

    def _first_change(
        self, chosen: Chosen, still: Sequence[Member], among: Mask
    ) -> tuple[Member, Member | None] | None:
        """The first of some members that is better in another form or gives way, and what comes in its place;
        of other components those alone are weighed that may be likelier."""
        places = [chosen.members.index(member) for member in still]
        can = [self._open(chosen, i, among) for i in places]
        others = sorted(set[int]().union(*can).difference(m.component for m in chosen.members))
        most = self.forms.most(chosen, others, places) if others else np.zeros((0, len(still)))
        mine = self._own_weights(chosen, places, can)
        for i, here, own, limit in zip(places, can, mine, most.T, strict=True):
            least = own.log_odds + CLEARLY if own is not None and own.log_odds > 0 else 0.0
            rivals = [k for k, top in zip(others, limit, strict=True) if top > least and k in here]
            weights = self._weights(chosen, rivals, i)
            member = chosen.members[i]
            if own is not None:
                weights[member.component] = own
            new = _likeliest(member, weights)
            if own is not None and member.component in self.certain:
                new = Member(member.component, own.form, own.scale)
            if new != member:
                return member, new
        return None

    def _own_weights(
        self, chosen: Chosen, places: Sequence[int], can: Sequence[Sequence[int]]
    ) -> Iterator[Weight | None]:
        """Of members by their places, beside the others; None where what one needs is not there."""
        own = [chosen.members[i].component for i in places]
        for at in range(0, len(own), AT_ONCE):
            some = range(at, min(at + AT_ONCE, len(own)))
            there = [n for n in some if own[n] in can[n]]
            weighed = self.forms.weigh(chosen, [own[n] for n in there], np.array([places[n] for n in there]))
            found = dict(zip(there, weighed, strict=True))
            yield from (found.get(n) for n in some)

    def shares(self, members: Sequence[Member]) -> list[Shares]:
        """For each member: probability of it, of each stand-in, and of nothing (None) in its place.

        What would help beside the whole set as well stands in for nobody by that; and nothing stands in for
        what is certain to be there.
        """
        out = []
        chosen, stand_ins = Chosen(self.reduced, members), StandIns(self.forms, self.components)
        strongest, now = self._strongest(chosen), self.score(members)
        otherwise = [(of, self.score(new) - now) for of, new in self._otherwise(members)]
        anyway = {k: max(w.log_odds, 0.0) for k, w in self.beside(chosen).items()}
        least = np.array([anyway[k] + self.components[k].log_odds + EXPLAINS for k in anyway])
        most = self.forms.most(chosen, list(anyway), range(len(members))) if members else np.zeros((0, 0))
        for i, (member, limit) in enumerate(zip(members, most.T, strict=True)):
            can = self._open(chosen, i, None)
            if member.component not in can:  # what it needs is gone
                out.append({member.component: 0.0, None: 1.0})
                continue
            may = {member.component}
            if member.component not in self.certain:
                may |= {*np.array([*anyway], int)[limit > least].tolist()}
            weights = self._weights(chosen, [k for k in can if k in may], i)
            logs = dict[int, float]()
            for k, w in weights.items():
                value = w.log_odds - anyway.get(k, 0.0)
                if k == member.component or value - self.components[k].log_odds > EXPLAINS:
                    logs[k] = value
            believed: Shares = {None: 0.0}
            believed.update(stand_ins.believed(chosen, i, weights, logs).items())
            own = member.component
            several = [*self._two_causes(members, i)] if i in strongest else []
            several += [(of[own], min(value, 0.0)) for of, value in otherwise if own in of]
            for k, value in several:
                believed[k] = float(np.logaddexp(believed.get(k, -np.inf), logs[own] + value))
            top = max(believed.values())
            mass = {k: float(np.exp(v - top)) for k, v in believed.items()}
            total = sum(mass.values())
            out.append({k: v / total for k, v in mass.items()})
        return out


def _likeliest(member: Member, weights: dict[int, Weight]) -> Member | None:
    """What is likeliest in a member's place, itself where nothing is clearly likelier; None: nothing."""
    k = max(sorted(weights), key=lambda k: weights[k].log_odds, default=None)
    if k is None or weights[k].log_odds <= 0:
        return None
    own = weights.get(member.component)
    if own is not None and weights[k].log_odds < own.log_odds + CLEARLY:
        k = member.component
    return Member(k, weights[k].form, weights[k].scale)
