"""Whether parts of the data, each searched by itself from the beginning, name the same; and what they do."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chndtr, expit

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..priors import PRIORS
from .chosen import Chosen, Member, Shares
from .components import Component, Key, bare
from .reduced import Index, Reduced
from .sets import Competition
from .side_by_side import begun

POSES_PER_JOINT = 10  # different joint positions, per joint, from which parts of the data can show a cause
LARGE = 1000  # points from which parts are worth processes of their own

Search = Callable[[Index], tuple[Sequence[Component], Sequence[Shares]]]
Seen = Callable[[Index], Sequence[tuple[float, float]]]


@dataclass(frozen=True)
class Part:
    """Some poses, and the shares of what a search of these alone found, by the numbers that the whole's
    components have; what these do not have counts as nothing."""

    poses: Index
    shares: list[Shares]

    def of(self, k: int) -> Shares:
        """The share in which a component is likeliest; empty where none has it."""
        return max(self.shares, key=lambda share: share.get(k, 0.0), default={})


@dataclass(frozen=True)
class InParts:
    """What searches of parts of the data found: their poses, and shares by what these are about."""

    poses: Sequence[Index]
    found: Sequence[Sequence[Mapping[Key | None, float]]]

    def told(self, components: Sequence[Component]) -> list[Part]:
        """By the numbers that some components have."""
        known = _known(components)
        return [
            Part(poses, [_translated(share, known) for share in shares])
            for poses, shares in zip(self.poses, self.found, strict=True)
        ]


@contextmanager
def searched_in_parts(problem: Problem, search: Search) -> Iterator[Callable[[], InParts]]:
    """Parts of the data, each searched by itself: these see nothing of what the others found. Of large
    campaigns it is begun on all cores at once; what this gives waits for it. search: of some poses,
    components and shares of what it finds."""

    def searched(poses: Index) -> list[dict[Key | None, float]]:
        theirs, found = search(poses)
        return [_by_key(share, theirs) for share in found]

    parts = parts_of(problem)
    if problem.seen.sum() < LARGE:
        yield lambda: InParts(parts, [searched(poses) for poses in parts])
        return
    with begun(searched, parts) as done:
        yield lambda: InParts(parts, done())


def replicated(
    parts: Sequence[Part],
    components: Sequence[Component],
    members: Sequence[Member],
    shares: Sequence[Shares],
    seen: Seen,
) -> list[Shares]:
    """The shares where the model does not fit to the noise, and the likelihood is far too sure: those of the
    parts, averaged, for members of which these say less. seen: of some poses, for each member how likely they
    would show it, and how likely they do beside all others. What they cannot show they do not deny; and a
    line in a gear, which is like nothing else, is denied by no search that lost its way among other causes.
    """
    known, told = _known(components), [seen(part.poses) for part in parts]
    out = [dict(share) for share in shares]
    for i, member in enumerate(members):
        if components[member.component].nameless:
            continue
        k = known[bare(components[member.component].key)]  # of a line it does not matter which
        line = components[member.component].key[1].order is not None
        mean = _mean(_of_part(part.of(k), k, *of[i], line) for part, of in zip(parts, told, strict=True))
        own = mean.pop(k, 0.0)
        if own < out[i][member.component]:
            out[i] = {**mean, member.component: own}
    return out


def _of_part(share: Shares, k: int, chance: float, shown: float, line: bool) -> Shares:
    """What a part says of component k."""
    if line and shown > share.get(k, 0.0):
        return {None: 1 - shown, k: shown}
    return share if k in share else {None: chance, k: 1 - chance}


def agreed(parts: Sequence[Part], components: Sequence[Component]) -> dict[int, Shares]:
    """The causes that the parts find by themselves, as surely as a name asks for, with their shares: what
    complementary halves select is no chance of one search (Shah & Samworth 2013)."""
    found = {k for part in parts for share in part.shares for k in share if k is not None}
    means = {k: _mean(part.of(k) for part in parts) for k in sorted(found) if not components[k].nameless}
    return {k: mean for k, mean in means.items() if mean.get(k, 0.0) >= PRIORS.named}


def joined(
    competition: Competition, agreed: dict[int, Shares], members: Sequence[Member], shares: Sequence[Shares]
) -> tuple[list[Member], list[Shares]]:
    """With the causes that the parts agree on, as sure as these are, though the whole's likeliest set does
    without them, or has them as a doubtful name for something else: a set that was chosen once, among many
    that are nearly as likely, is no witness against them."""
    members, shares = list(members), list(shares)
    have = {bare(competition.components[m.component].key): i for i, m in enumerate(members)}
    for k, share in agreed.items():
        i = have.get(bare(competition.components[k].key))
        if i is None:
            weight = competition.beside(Chosen(competition.reduced, members)).get(k)
            if weight is None:  # what it needs is not there
                continue
            members.append(Member(k, weight.form, weight.scale))
            shares.append(share)
        elif shares[i].get(members[i].component, 0.0) < share[k]:
            rest = {other: p for other, p in share.items() if other != k}
            shares[i] = {**rest, members[i].component: share[k]}
    return members, shares


def power(
    whole: Reduced, part: Reduced, members: Sequence[Member], components: Sequence[Component]
) -> list[float]:
    """For each member, of the size that the whole gives it, the chance that a part has it likelier there than
    not beside the others: that what it takes off χ² exceeds what its freedom and its prior cost.

    part: reduced equations of the members' own components alone, in their order. A number that the part shows
    with d and the prior holds with s⁻² takes w χ²(1, d β²), w = s² d/(1 + s² d): of many columns that hardly
    count little is taken by chance."""
    there = [replace(member, component=i) for i, member in enumerate(members)]
    size, beside, out = Chosen(whole, members), Chosen(part, there), []
    for i, member in enumerate(members):
        S, cost = beside.price(i, components[member.component])
        d, axes = np.linalg.eigh(S)
        d = np.maximum(d, 0.0)
        shift = d * (axes.T @ size.beta[size.own[i]]) ** 2
        weight = member.scale**2 * d / (1 + member.scale**2 * d)
        out.append(exceeds(weight, shift, cost))
    return out


def shown_by(part: Reduced, components: Sequence[Component], members: Sequence[Member]) -> list[float]:
    """For each member the probability that a part's own poses give it beside all others. part: reduced
    equations of the members' own components alone, in their order."""
    there = [replace(member, component=i) for i, member in enumerate(members)]
    competition, chosen = Competition(part, components), Chosen(part, there)
    weights = (competition.beside(chosen, i)[i] for i in range(len(there)))
    return [float(expit(weight.log_odds)) for weight in weights]


def exceeds(weight: Array, shift: Array, limit: float) -> float:
    """Chance that Σ weight χ²(1, shift) exceeds a limit, by a noncentral χ² with its moments (Liu et al.
    2009). weight, shift: (p,), not negative."""
    c1, c2, c3, c4 = (float((weight**k * (1 + k * shift)).sum()) for k in (1, 2, 3, 4))
    if c2 <= 0:
        return float(limit < 0)
    skew, tail = c3 / c2**1.5, c4 / c2**2
    a = 1 / (skew - np.sqrt(max(skew**2 - tail, 0.0)))
    off = skew * a**3 - a**2
    dof = a**2 - 2 * off
    at = a * (limit - c1) / np.sqrt(c2) + dof + off
    return 1 - float(chndtr(max(at, 0.0), dof, max(off, 0.0)))


def renamed(
    competition: Competition, members: Sequence[Member], shares: Sequence[Shares], below: float = 1.0
) -> tuple[list[Member], list[Shares]]:
    """The members and their shares, with what the parts have in the place of one where that is likelier than
    this; once, where it comes in the place of two. below: only of those that have less themselves."""
    out = dict[int, tuple[Member, Shares]]()
    for member, share in zip(members, shares, strict=True):
        k, new = max(share, key=lambda k: share[k]), member
        faint = share.get(member.component, 0.0) < below
        if faint and k not in (None, member.component) and share.get(None, 0.0) < share[k]:
            others = [m for m in members if m is not member and m.component != k]
            weight = competition.beside(Chosen(competition.reduced, others)).get(k)
            if weight is not None:  # else what it needs is not there
                new = Member(k, weight.form, weight.scale)
        had = out.get(new.component)
        if had is None or had[1].get(new.component, 0.0) < share.get(new.component, 0.0):
            out[new.component] = new, share
    return [member for member, _ in out.values()], [share for _, share in out.values()]


def _known(components: Sequence[Component]) -> dict[Key, int]:
    return {bare(component.key): k for k, component in reversed([*enumerate(components)])}


def _mean(shares: Iterable[Shares]) -> Shares:
    every = list(shares)
    keys = set[int | None]().union(*every)
    return {key: sum(share.get(key, 0.0) for share in every) / len(every) for key in keys}


def _by_key(share: Shares, components: Sequence[Component]) -> dict[Key | None, float]:
    """A share by what its components are about, and not by their numbers."""
    out: dict[Key | None, float] = {None: 0.0}
    for k, p in share.items():
        key = None if k is None else bare(components[k].key)
        out[key] = out.get(key, 0.0) + p
    return out


def _translated(share: Mapping[Key | None, float], known: Mapping[Key, int]) -> Shares:
    """A share by the numbers of components; what these do not have counts as nothing."""
    out: Shares = {None: 0.0}
    for key, p in share.items():
        k = None if key is None else known.get(key)
        out[k] = out.get(k, 0.0) + p
    return out


def enough_for_halves(problem: Problem) -> bool:
    """Whether there are joint positions enough for parts of them to show a cause."""
    return len(np.unique(problem.positions)) >= POSES_PER_JOINT * problem.arm.n


def parts_of(problem: Problem) -> list[Index]:
    """Poses of each set-up, where two or more have poses enough to show a cause; else the earlier and the
    later half, and two halves drawn at random, of every set-up and payload."""
    setup = problem.campaign.poses.setup
    each = [np.flatnonzero(setup == k) for k in range(int(setup.max(initial=0)) + 1)]
    enough = POSES_PER_JOINT * problem.arm.n
    large = [poses for poses in each if len(np.unique(problem.positions[poses])) >= enough]
    if len(large) > 1:
        return large
    poses = problem.campaign.poses
    which = np.unique(np.column_stack([poses.setup, poses.payload]), axis=0, return_inverse=True)[1].ravel()
    groups = [np.flatnonzero(which == group) for group in range(int(which.max()) + 1)]
    early, late = [own[: len(own) // 2] for own in groups], [own[len(own) // 2 :] for own in groups]
    mixed = [own[np.argsort(poses.drawn()[own], kind="stable")] for own in groups]
    one, other = [own[: len(own) // 2] for own in mixed], [own[len(own) // 2 :] for own in mixed]
    return [np.sort(np.concatenate(part)) for part in (early, late, one, other)]
