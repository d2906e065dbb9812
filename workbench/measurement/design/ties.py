"""What stands open between a cause and its rivals, how far apart they are, and the fewest records that settle
it.

λ is that of `t_optimal`, for the size that the cause was found with; the rival is taken as large as imitates
it best in what was measured. A rival may contain the cause, as a map of a joint contains the sine of its
wheel: no pose tells the sine from that, only that nothing else of the map is seen; its λ is that of the rest
of it, in the size that imitates the cause.

Settled is a tie where a diagnosis is expected to name what is true, be it the cause or one of the rivals, by
the odds of `expected_odds`: at the share `POWER` of the probability that these have now.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from ...diagnosis.components import Key, with_companions
from ...diagnosis.priors import PRIORS
from ...diagnosis.result import Finding
from ...diagnosis.run import Outcome
from ...diagnosis.stand_ins import times_too_sure
from ...effects import catalogue
from ...effects.base import UNKNOWN, Effect
from ...effects.unnamed import unnamed
from ...identification.fit import Fit
from ...robot.kinematics import Array
from .candidates import random_draws
from .discrimination_plan import LEVELS, MOST_MEASURED
from .expected_odds import Pattern, Weighed, share_of_way
from .fedorov import Records, Search, information
from .prior_information import WIDE, ValuedEffects, from_prepared
from .t_optimal import DesignSpace, Pair, design_space, t_optimal

SAID = 3  # digits of a size, as commands say it
SMALLEST = 0.1  # usual sizes, of a rival that hardly imitates
INSIDE = 0.2  # share of λ that what contains a cause leaves of it, at most
IMITATES = 0.5  # share of λ that a rival leaves, at most, to be taken for the cause
ODDS = 2 * np.log(PRIORS.named / (1 - PRIORS.named))  # twice the log odds from which a cause is named
SPARE = 2.0  # what is asked of records at least, where the odds are nearly there
FAINTEST = 1e-6  # probability that is told from none
POWER = 0.95  # share of the probability that is to be named afterwards

Columns = NDArray[np.int64]
SizedEffects = tuple[tuple[Effect, Array], ...]


@dataclass(frozen=True)
class Tie:
    """An effect that was found, its size (p,) in usual ones, and the effects that rival it. forms: of each of
    these, and of rivals without a name, the effect and its companions with their prior sizes; chances: the
    probability of each, by its key, where they are known."""

    effect: Effect
    size: Array
    rivals: tuple[Effect, ...]
    forms: tuple[SizedEffects, ...]
    chances: Mapping[Key, float]

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
            forms=tuple(form for form in self.forms if form[0][0].key in kept),
        )

    def patterns(self, space: DesignSpace) -> list[Pattern]:
        """The forms in the columns of a space."""
        out = []
        for form in self.forms:
            columns = np.concatenate([space.columns(effect) for effect, _ in form]) - space.background
            usual = [size / [p.typical for p in effect.params] for effect, size in form]
            out.append(Pattern(columns, np.concatenate(usual), form[0][0].cause != UNKNOWN))
        return out


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
    known = catalogue()
    kinds = [known[cause] for cause in dict.fromkeys(cause for cause, _ in kept) if cause in known]
    sites = (e for kind in kinds for e in kind.sites(fit.model.problem))
    return tuple(e for e in sites if e.key in kept and not any(item.is_for(e) for item in given))


def tie_between(
    fit: Fit, effect: Effect, values: Array, rivals: tuple[Effect, ...], chances: Mapping[Key, float]
) -> Tie:
    """The tie of an effect that was found with these values (p,); chances: by key, none: nothing is known.
    The values count as commands say them: a diagnosis, its result.json and a plan speak of one tie."""
    values = np.array([float(f"{value:.{SAID}g}") for value in values])
    nameless = [e for e in unnamed(fit.model.problem) if e.key in chances]
    every = (effect, *rivals, *nameless)
    forms = tuple(tuple(with_companions(fit, (one,), fit.model.problem)) for one in every)
    return Tie(effect, values / np.array([p.typical for p in effect.params]), rivals, forms, chances)


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
            imitation = _imitation(before, i - space.background, j - space.background, tie.size)
            scale[i] = np.maximum(np.abs(tie.size) * np.sqrt(len(i)), SMALLEST)
            of_rest = contains(space, rival, tie.effect)
            scale[j] = np.maximum(np.abs(imitation) * np.sqrt(len(j)), SMALLEST)
            scale[j] = _size_of(imitation) if of_rest else scale[j]
    return replace(space, rows=space.rows * scale, before=space.before * np.outer(scale, scale))


def contains(space: DesignSpace, whole: Effect, part: Effect) -> bool:
    """Whether one effect can be all that another is, in everything on offer, and more."""
    j, i = (space.columns(effect) - space.background for effect in (whole, part))
    if len(j) <= len(i):
        return False
    left = space.left(space.everything)
    beside = [unexplained(left, i, j, one, WIDE**-2) for one in np.eye(len(i))]
    return sum(beside) < INSIDE * float(np.trace(left[np.ix_(i, i)]))


def least(space: DesignSpace, data: Array, tie: Tie) -> float:
    """The smallest λ of the cause beside each of its rivals, and of each rival beside the cause, with the
    information data: (P, P)."""
    before, after = space.left(space.before), space.left(data)
    return min(_apart(space, before, after, tie, rival) for rival in tie.rivals)


def share_of(space: DesignSpace, data: Array, tie: Tie) -> float:
    """How much of what settles a tie the information data: (P, P) is worth; from one it is settled:
    at the share `POWER` of the probability, whichever effect is true is expected to be named."""
    patterns = tie.patterns(space)
    before, after = (Weighed(space.left(one), patterns) for one in (space.before, data))
    keys = [form[0][0].key for form in tie.forms]
    own = patterns[0].columns[: len(tie.size)]
    shares = []
    for key in dict.fromkeys(key for key in keys if key[0] != UNKNOWN):
        of_key = [k for k, one in enumerate(keys) if one == key]
        k = max(of_key, key=lambda k: before.evidence(k, own, tie.size)[0])
        columns = own if k == 0 else patterns[k].columns
        size = tie.size if k == 0 else before.imitation(k, own, tie.size)
        shares.append((_named_share(tie, keys, k, (before, after), columns, size), tie.chance(key)))
    shares.sort(reverse=True, key=lambda one: one[0])
    reached = np.cumsum([chance for _, chance in shares])
    return shares[int(np.searchsorted(reached, POWER * reached[-1]))][0]


def _named_share(
    tie: Tie,
    keys: Sequence[Key],
    k: int,
    weighed: tuple[Weighed, Weighed],
    columns: Columns,
    size: Array,
) -> float:
    """How much of the way it is to the k-th form's name, were it true with this size (t,) in these columns,
    beside the rival that holds out longest."""
    before, after = weighed
    wanted = ODDS + 2 * float(np.log(len({*keys} - {keys[k]})))  # all rivals together keep the rest
    own = after.evidence(k, columns, size)[0] - before.evidence(k, columns, size)[0]
    shares = []
    for other, key in enumerate(keys):
        if key == keys[k]:
            continue
        now, left = before.evidence(other, columns, size)
        then, more = after.evidence(other, columns, size)
        odds = 2 * float(np.log(tie.chance(keys[k]) / tie.chance(key)))
        needed = max(wanted - odds, SPARE)
        slow = 1.0 if key[0] == UNKNOWN else times_too_sure(tie.forms[k][0][0], tie.forms[other][0][0])
        gain, variance = own - (then - now), 4 * (more - left)
        shares.append(share_of_way(gain / slow, variance / slow**2, needed))
    return min(shares)


def _apart(space: DesignSpace, before: Array, after: Array, tie: Tie, rival: Effect) -> float:
    """λ of the cause beside a rival and, where that imitates it, of the rival beside the cause, the smaller;
    of what contains the other its own alone."""
    i, j = (space.columns(effect) - space.background for effect in (tie.effect, rival))
    imitation = _imitation(before, i, j, tie.size)
    if contains(space, rival, tie.effect):
        return float(_size_of(imitation) ** 2 * np.trace(_rest(after, i, j)))
    own = unexplained(after, i, j, tie.size, WIDE**-2)
    alone = unexplained(before, i, j[:0], tie.size, 0.0)
    imitates = unexplained(before, i, j, tie.size, WIDE**-2) < IMITATES * alone
    if contains(space, tie.effect, rival) or not imitates:
        return own
    return min(own, unexplained(after, j, i, imitation, WIDE**-2))


def _size_of(imitation: Array) -> float:
    """Usual sizes of a function that has these numbers."""
    return max(float(np.sqrt(np.mean(imitation**2))), SMALLEST)


def _rest(left: Array, i: Columns, j: Columns) -> Array:
    """(q, q) information on columns j beside columns i."""
    cross = left[np.ix_(i, j)]
    return np.asarray(
        left[np.ix_(j, j)] - cross.T @ np.linalg.solve(left[np.ix_(i, i)] + WIDE**-2 * np.eye(len(i)), cross)
    )


def _imitation(left: Array, i: Columns, j: Columns, size: Array) -> Array:
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
    """The fewest records that settle all ties, and the share of the way that the hardest of them goes
    (`share_of`); below one: none settle them, and these were tried last."""
    steering = as_found(space, ties)
    count, found, reached = attempts.first, None, 0.0
    for _ in range(attempts.times):
        chosen, share = best_records(space, steering, ties, count, search)
        if found is None or share >= 1 or reached < 1:
            found, reached = chosen, share
        most = min(attempts.most, len(space.rows))
        needed = records_needed(space, chosen, ties) or np.inf
        wanted = int(np.clip(np.ceil(attempts.margin * needed), attempts.fewest, most))
        if wanted == count or (reached >= 1 and wanted >= len(found)):
            break
        count = wanted
    assert found is not None
    return found, reached


def best_records(
    space: DesignSpace, steering: DesignSpace, ties: Sequence[Tie], count: int, search: Search
) -> tuple[Records, float]:
    """`count` records, sorted, and their share of the way: the best of those with the largest λ of the
    causes beside their rivals, of all beside all, and of some random ones, which λ alone may not see."""
    causes, every = (
        tuple(dict.fromkeys(pair for tie in ties for pair in of(tie, space)))
        for of in (Tie.pairs, Tie.all_pairs)
    )
    quick = replace(search, starts=1)
    designs = [t_optimal(steering, pairs, count, quick) for pairs in dict.fromkeys((causes, every))]
    designs += random_draws(len(space.rows), count, search.seed)
    shares = [least_share(space, space.measured(design), ties) for design in designs]
    best = int(np.argmax(shares))
    return designs[best], shares[best]


def least_share(space: DesignSpace, data: Array, ties: Sequence[Tie]) -> float:
    """`share_of` of the hardest of some ties."""
    return min(share_of(space, data, tie) for tie in ties)


def records_needed(space: DesignSpace, chosen: Records, ties: Sequence[Tie]) -> int | None:
    """How many records in the proportions of these settle all ties; None: more than anyone measures. What
    tells does not grow as their number: odds beside what contains the cause grow as its logarithm."""

    def settled(count: int) -> bool:
        return least_share(space, space.measured(chosen, count), ties) >= 1

    if not settled(MOST_MEASURED):
        return None
    return 1 + bisect_left(range(1, MOST_MEASURED), True, key=settled)
