"""What stands open between a cause and its rivals, how far apart they are, and the fewest records that settle
it.

λ is that of `t_optimal`, for the size that the cause was found with; the rival is taken as large as imitates
it best in what was measured. A rival may contain the cause, as a map of a joint contains the sine of its
wheel: no pose tells the sine from that, only that nothing else of the map is seen; its λ is that of the rest
of it, in the size that imitates the cause.

Settled is a tie where a diagnosis names what is true with a probability of `POWER`, be it the cause or one of
the rivals, each as likely as it is now (`expected_odds`).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from ...campaign.planned import joint_ranges
from ...campaign.problem import Problem
from ...diagnosis.found import Finding
from ...diagnosis.run import Outcome
from ...diagnosis.weighing.components import Key, at_once, by_key, log_odds_of, with_companions
from ...diagnosis.weighing.stand_ins import times_too_sure
from ...effects import catalogue
from ...effects.base import UNKNOWN, Effect
from ...effects.unnamed import unnamed
from ...identification.fit import Fit
from ...robot.kinematics import Array
from .candidates import random_draws
from .discrimination_plan import LEVELS, MOST_MEASURED
from .expected_odds import Hypotheses, Outlook, Pattern
from .fedorov import Records, Search, information
from .prior_information import WIDE, ValuedEffects, from_prepared
from .t_optimal import DesignSpace, Pair, design_space, t_optimal

SAID = 3  # digits of a size, as commands say it
SMALLEST = 0.1  # usual sizes, of a rival that hardly imitates
INSIDE = 0.2  # share of λ that what contains a cause leaves of it, at most
IMITATES = 0.5  # share of λ that a rival leaves, at most, to be taken for the cause
FAINTEST = 1e-6  # probability that is told from none
POWER = 0.8  # probability from which records are said to settle a tie

Columns = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class SizedForm:
    """Effects with their prior sizes; all but the first `own` are companions of these."""

    own: int
    sized: tuple[tuple[Effect, Array], ...]

    def __iter__(self) -> Iterator[tuple[Effect, Array]]:
        return iter(self.sized)

    @property
    def first(self) -> Effect:
        return self.sized[0][0]


@dataclass(frozen=True, eq=False)
class Tie:
    """An effect that was found, its size (p,) in usual ones, and the effects that rival it. forms: of each of
    these, and of rivals without a name, the effect and its companions with their prior sizes; chances: the
    probability of each, by its key, where they are known; log_odds: before the data, of each with a name that
    is no line in a gear."""

    effect: Effect
    size: Array
    rivals: tuple[Effect, ...]
    forms: tuple[SizedForm, ...]
    chances: Mapping[Key, float]
    log_odds: Mapping[Key, float]

    def chance(self, key: Key) -> float:
        return max(self.chances.get(key, 1.0), FAINTEST)

    def pairs(self, space: DesignSpace) -> list[Pair]:
        """The cause beside each rival, and each rival beside the cause; not what another contains."""
        ways = [way for rival in self.rivals for way in ((self.effect, rival), (rival, self.effect))]
        return [way for way in ways if not contains(space, way[1], way[0])]

    def all_pairs(self, space: DesignSpace) -> list[Pair]:
        """The same, and each rival beside each other: any of them may be what is true."""
        every = permutations((self.effect, *self.rivals), 2)
        return [(a, b) for a, b in every if a.key != b.key and not contains(space, b, a)]

    def beside(self, key: Key) -> Tie:
        """The tie with one of its rivals alone, in every form of it."""
        kept = {self.effect.key, key}
        return replace(
            self,
            rivals=tuple(rival for rival in self.rivals if rival.key == key),
            forms=tuple(form for form in self.forms if form.first.key in kept),
        )

    def without(self, keys: Collection[Key]) -> Tie:
        """The tie without some of its rivals."""
        return replace(
            self,
            rivals=tuple(rival for rival in self.rivals if rival.key not in keys),
            forms=tuple(form for form in self.forms if form.first.key not in keys),
        )

    def hypotheses(self, space: DesignSpace) -> Hypotheses:
        """What may be true, in the columns of a space."""
        firsts = {form.first.key: form.first for form in reversed(self.forms)}
        keys = list(dict.fromkeys(form.first.key for form in self.forms))
        patterns = []
        for form in self.forms:
            columns = np.concatenate([space.columns(effect) for effect, _ in form]) - space.background
            usual = [size / [p.typical for p in effect.params] for effect, size in form]
            key = form.first.key
            own = sum(map(len, usual[: form.own]))
            patterns.append(Pattern(columns, np.concatenate(usual), keys.index(key), own, key[0] != UNKNOWN))
        named = np.array([key[0] != UNKNOWN for key in keys])
        slow = [
            [times_too_sure(firsts[a], firsts[b]) if UNKNOWN not in (a[0], b[0]) else 1.0 for b in keys]
            for a in keys
        ]
        chances = np.array([self.chance(key) for key in keys])
        less = np.array([[self._less(a, b) for b in keys] for a in keys])
        return Hypotheses(tuple(patterns), chances, np.array(slow), named, less)

    def _less(self, one: Key, other: Key) -> float:
        """log of by how much less likely the other was than the one before the data, as far as both have a
        name: functions without one stand for what nobody knows."""
        if one not in self.log_odds or other not in self.log_odds:
            return 0.0
        return max(self.log_odds[one] - self.log_odds[other], 0.0)


@dataclass(frozen=True)
class Attempts:
    """How the fewest records are looked for. first, fewest, most: records that are tried; times: how often at
    most; margin: by how much more than is thought to do it."""

    first: int
    fewest: int
    most: int
    times: int
    margin: float


def tie_of(outcome: Outcome, finding: Finding) -> Tie | None:
    """The finding as effects; None where it is named, or no rival has a name."""
    if finding.status == "named" or finding.cause == UNKNOWN:
        return None
    own = [i for i, e in enumerate(outcome.fit.model.effects) if e.key == (finding.cause, finding.where)]
    said = {(rival.cause, rival.where): rival.probability for rival in finding.rivals}
    chances = said | {(rival.cause, rival.where): rival.probability for rival in finding.faint}
    rivals = sites_of(chances, outcome.prepared.geometry)
    if not own or not any(rival.key in said for rival in rivals):
        return None
    strongest = max(own, key=outcome.fit.wald)
    effect, values = outcome.fit.model.effects[strongest], outcome.fit.state.values[strongest]
    chances[effect.key] = finding.probability
    return tie_between(outcome.prepared.geometry, effect, values, rivals, chances)


def sites_of(keys: Iterable[Key], fit: Fit) -> tuple[Effect, ...]:
    """Every form of the causes of the catalogue with these keys that a campaign may show, in their order; but
    for what is known already."""
    kept, given = tuple(keys), fit.model.given
    known, about = catalogue(), wherever(fit.model.problem)
    kinds = [known[cause] for cause in dict.fromkeys(cause for cause, _ in kept) if cause in known]
    sites = (e for kind in kinds for e in kind.sites(about))
    return tuple(e for e in sites if e.key in kept and not any(item.is_for(e) for item in given))


def tie_between(
    fit: Fit, effect: Effect, values: Array, rivals: tuple[Effect, ...], chances: Mapping[Key, float]
) -> Tie:
    """The tie of an effect that was found with these values (p,); chances: by key, none: nothing is known.
    The values count as commands say them: a diagnosis, its result.json and a plan speak of one tie."""
    values = np.array([float(f"{value:.{SAID}g}") for value in values])
    about = wherever(fit.model.problem)
    other_forms = [e for e in sites_of([effect.key], fit) if e != effect]
    nameless = [e for e in unnamed(about) if e.key in chances]
    every = (effect, *other_forms, *rivals, *nameless)
    sets: list[tuple[Effect, ...]] = [(one,) for one in every]
    sets += [some for own in by_key(every).values() for some in at_once(own)]
    forms = [SizedForm(len(some), tuple(with_companions(fit, some, about))) for some in sets]
    forms += [
        SizedForm(form.own, form.sized[: form.own])
        for form in forms
        if form.first.pure and len(form.sized) > form.own
    ]
    forms += [
        SizedForm(1, tuple(with_companions(fit, (one,), about, rarer=True)))
        for one in every
        if one.rarer(about)
    ]
    size = values / np.array([p.typical for p in effect.params])
    return Tie(effect, size, rivals, tuple(forms), chances, _log_odds(every, fit))


def _log_odds(effects: Sequence[Effect], fit: Fit) -> dict[Key, float]:
    """log odds before the data of causes at their places, by key; not of lines in a gear."""
    known, given, about = catalogue(), fit.model.given, wherever(fit.model.problem)
    named = [one for one in effects if one.cause in known and one.where.order is None]
    sites = {
        cause: len({e.key for e in known[cause].sites(about) if not any(item.is_for(e) for item in given)})
        for cause in {one.cause for one in named}
    }
    return {one.key: log_odds_of(one, max(sites[one.cause], 1)) for one in named}


def wherever(problem: Problem) -> Problem:
    """The problem as if its poses were all over the joints' ranges: further poses are, so that functions of a
    joint reach as far."""
    q, (lower, upper) = problem.q, joint_ranges(problem.robot)
    low, high = np.minimum(lower, q.min(axis=0)), np.maximum(upper, q.max(axis=0))
    over = np.ptp(q, axis=0)
    even = np.linspace(0, 1, len(q))[:, None]
    share = np.where(over > 0, (q - q.min(axis=0)) / np.where(over > 0, over, 1.0), even)
    return replace(problem, campaign=problem.campaign.with_poses(q=low + share * (high - low)))


def told_apart(outcome: Outcome, tie: Tie, before: Outcome) -> float:
    """λ of a tie in all that an outcome was made of; before: the outcome that left it."""
    valued = at_zero((tie,))
    both, first = (from_prepared(one.prepared).of_campaign(valued) for one in (outcome, before))
    assert both is not None
    space = design_space(both, first)
    return least(space, information(space.rows), tie)


def at_zero(ties: Sequence[Tie]) -> ValuedEffects:
    """The effects of ties, at zero."""
    effects = dict.fromkeys(effect for tie in ties for form in tie.forms for effect, _ in form)
    return tuple((effect, np.zeros(len(effect.params))) for effect in effects)


def as_found(space: DesignSpace, ties: Sequence[Tie]) -> DesignSpace:
    """The space with each cause in the size that was found, and each rival as large as imitates it best, in
    place of their usual sizes: what is hardest in it is what is hardest to settle."""
    scale, before = np.ones(len(space.names)), space.left(space.before)
    for tie in ties:
        for rival in tie.rivals:
            i, j = (space.columns(effect) for effect in (tie.effect, rival))
            like = imitation(before, i - space.background, j - space.background, tie.size)
            scale[i] = np.maximum(np.abs(tie.size) * np.sqrt(len(i)), SMALLEST)
            of_rest = contains(space, rival, tie.effect)
            scale[j] = np.maximum(np.abs(like) * np.sqrt(len(j)), SMALLEST)
            scale[j] = _size_of(like) if of_rest else scale[j]
    return replace(space, rows=space.rows * scale, before=space.before * np.outer(scale, scale))


def contains(space: DesignSpace, whole: Effect, part: Effect) -> bool:
    """Whether one effect can be all that another is, in everything on offer, and more."""
    j, i = (space.columns(effect) - space.background for effect in (whole, part))
    if len(j) <= len(i):
        return False
    left = space.left_of_everything
    beside = [unexplained(left, i, j, one, WIDE**-2) for one in np.eye(len(i))]
    return sum(beside) < INSIDE * float(np.trace(left[np.ix_(i, i)]))


def least(space: DesignSpace, data: Array, tie: Tie) -> float:
    """The smallest λ of the cause beside each of its rivals, and of each rival beside the cause, with the
    information data: (P, P)."""
    before, after = space.left(space.before), space.left(data)
    return min(_apart(space, before, after, tie, rival) for rival in tie.rivals)


@dataclass(frozen=True, eq=False)
class Settling:
    """What records of a space are expected to make of some ties."""

    space: DesignSpace
    ties: Sequence[Tie]

    @cached_property
    def _outlooks(self) -> list[Outlook]:
        now = self.space.left(self.space.before)
        own = [self.space.columns(tie.effect) - self.space.background for tie in self.ties]
        return [
            Outlook(now, now[:, i] @ tie.size, tie.hypotheses(self.space))
            for i, tie in zip(own, self.ties, strict=True)
        ]

    def power(self, data: Array) -> float:
        """Probability that the hardest tie is settled with the information data: (P, P)."""
        left = self.space.left(data)
        return min(one.after(left).named for one in self._outlooks)

    def believed(self, data: Array) -> float:
        """Mean probability that a diagnosis gives to what is true of the hardest tie, with the information
        data: (P, P): what tells of records that settle none yet, or more than one would."""
        left = self.space.left(data)
        return min(one.after(left).believed for one in self._outlooks)

    def needed(self, chosen: Records) -> int | None:
        """How many records in the proportions of these settle all ties; None: more than anyone measures."""

        def settled(count: int) -> bool:
            return self.power(self.space.measured(chosen, count)) >= POWER

        if not settled(MOST_MEASURED):
            return None
        return 1 + bisect_left(range(1, MOST_MEASURED), True, key=settled)


def _apart(space: DesignSpace, before: Array, after: Array, tie: Tie, rival: Effect) -> float:
    """λ of the cause beside a rival and, where that imitates it, of the rival beside the cause, the smaller;
    of what contains the other its own alone."""
    i, j = (space.columns(effect) - space.background for effect in (tie.effect, rival))
    like = imitation(before, i, j, tie.size)
    if contains(space, rival, tie.effect):
        return float(_size_of(like) ** 2 * np.trace(_rest(after, i, j)))
    own = unexplained(after, i, j, tie.size, WIDE**-2)
    alone = unexplained(before, i, j[:0], tie.size, 0.0)
    imitates = unexplained(before, i, j, tie.size, WIDE**-2) < IMITATES * alone
    if contains(space, tie.effect, rival) or not imitates:
        return own
    return min(own, unexplained(after, j, i, like, WIDE**-2))


def _size_of(imitation: Array) -> float:
    """Usual sizes of a function that has these numbers."""
    return max(float(np.sqrt(np.mean(imitation**2))), SMALLEST)


def _rest(left: Array, i: Columns, j: Columns) -> Array:
    """(q, q) information on columns j beside columns i."""
    cross = left[np.ix_(i, j)]
    return np.asarray(
        left[np.ix_(j, j)] - cross.T @ np.linalg.solve(left[np.ix_(i, i)] + WIDE**-2 * np.eye(len(i)), cross)
    )


def imitation(left: Array, i: Columns, j: Columns, size: Array) -> Array:
    """The size of columns j that imitates columns i best."""
    S = left[np.ix_(j, j)] + WIDE**-2 * np.eye(len(j))
    return np.asarray(np.linalg.solve(S, left[np.ix_(j, i)] @ size), dtype=np.float64)


def unexplained(left: Array, i: Columns, j: Columns, size: Array, held: float) -> float:
    """λ of columns i in a size beside columns j, which are held to zero with this information."""
    cross = left[np.ix_(j, i)]
    S = left[np.ix_(j, j)] + held * np.eye(len(j))
    alone = left[np.ix_(i, i)] - cross.T @ np.linalg.solve(S, cross)
    return max(float(size @ alone @ size), 0.0)


def settled_at(now: float) -> float:
    """λ that settles it: more than there is where a rival holds out against it."""
    return max(LEVELS.mostly, now + LEVELS.least)


def fewest(
    space: DesignSpace, ties: Sequence[Tie], search: Search, attempts: Attempts
) -> tuple[Records, float]:
    """The fewest records that settle all ties, and the probability that they do; below `POWER`: none settle
    them, and these were tried last."""
    steering, settling = as_found(space, ties), Settling(space, ties)
    count, found, reached = attempts.first, None, 0.0
    for _ in range(attempts.times):
        chosen = best_records(settling, steering, count, search)
        now = settling.power(space.measured(chosen))
        if found is None or now >= POWER or reached < POWER:
            found, reached = chosen, now
        most = min(attempts.most, len(space.rows))
        needed = settling.needed(chosen) or np.inf
        wanted = int(np.clip(np.ceil(attempts.margin * needed), attempts.fewest, most))
        if wanted == count or (reached >= POWER and wanted >= len(found)):
            break
        count = wanted
    assert found is not None
    return found, reached


def best_records(settling: Settling, steering: DesignSpace, count: int, search: Search) -> Records:
    """`count` records, sorted: the best of those with the largest λ of the causes beside their rivals, of all
    beside all, of all ties or of each alone, which may settle the others as well, and of some random ones,
    which λ alone may not see."""
    space, ties = settling.space, settling.ties
    asked = [
        tuple(dict.fromkeys(pair for tie in some for pair in of(tie, space)))
        for some in dict.fromkeys((tuple(ties), *((tie,) for tie in ties)))
        for of in (Tie.pairs, Tie.all_pairs)
    ]
    quick = replace(search, starts=1)
    designs = [t_optimal(steering, pairs, count, quick) for pairs in dict.fromkeys(asked)]
    designs += random_draws(len(space.rows), count, search.seed)
    return max(designs, key=lambda design: settling.believed(space.measured(design)))
