"""The next records to discriminate between rival causes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from ...campaign import Campaign
from ...campaign.problem import Problem
from ...effects import separation_beside
from ...effects.base import Effect
from ...effects.given import given_facts
from ...files.faults import Fault, InputError
from ...robot.kinematics import Array
from ..driving.ways import Ways
from .budget import Question, check_sessions, in_time
from .candidates import Factors, candidates, random_draws, take
from .causes import EXAMPLE, factors, named_causes
from .discrimination_plan import LEVELS, MOST_MEASURED, TELLS, Discrimination, DiscriminationPlan
from .fedorov import Records, Search, check_count, information
from .prior_information import PriorInformation, ValuedEffects
from .shown import check_shown
from .t_optimal import DesignSpace, Pair, design_space, t_optimal


@dataclass(frozen=True, eq=False)
class TellSpace(Question):
    """Candidate records, the pairs of causes that they may tell apart, and what they cannot; asked: of every
    two causes that were named, all pairs of their places, both ways."""

    prior: PriorInformation
    effects: ValuedEffects
    offered: Campaign
    space: DesignSpace
    pairs: tuple[Pair, ...]
    asked: tuple[tuple[Pair, ...], ...]
    hopeless: tuple[Pair, ...]
    unseen: tuple[Effect, ...]
    separate_by: str
    search: Search

    def looking_at(self, names: Collection[str]) -> TellSpace:
        offered = self.offered.looking_at(names)
        rows = self.prior.of_records(offered, self.effects).on(self.space.names)
        return replace(self, offered=offered, space=replace(self.space, rows=rows))

    def chosen(self, among: Records, count: int) -> Records:
        """The records (count,) with the largest λ of the hardest pair."""
        part = replace(self.space, rows=self.space.rows[among])
        return among[t_optimal(part, self.pairs, count, replace(self.search, starts=1))]

    def data(self, records: Campaign) -> Array:
        """(P, P) information of the campaign and of these records."""
        rows = self.prior.of_records(records, self.effects).on(self.space.names)
        return self.space.before + information(rows)

    def worth(self, records: Campaign) -> float:
        """λ of the hardest pair, less what was there before."""
        return self.worth_of(self.data(records))

    def worth_of(self, data: Array) -> float:
        """The same of data (P, P)."""
        now = float(self.space.criterion(self.space.before, self.pairs).min())
        return float(self.space.criterion(data, self.pairs).min()) - now


def tell_space(prior: PriorInformation, text: str, search: Search) -> TellSpace:
    """Candidates that tell the causes of `text` apart. Raises InputError where the text names no two causes,
    or causes that these records cannot have."""
    offered, causes = _offered(prior, text, search)
    effects = list(dict.fromkeys(effect for cause in causes for effect in cause))
    at_zero = tuple((effect, np.zeros(len(effect.params))) for effect in effects)
    space = design_space(prior.of_records(offered, at_zero), prior.of_campaign(at_zero))
    everything = space.before + information(space.rows)
    check_shown(space, causes, prior)
    unseen = [effect for effect in effects if space.alone(everything, effect) < LEVELS.least]
    pairs = _pairs(causes, unseen)
    asked = tuple(filter(None, (tuple(_pairs(two, unseen)) for two in combinations(causes, 2))))
    if not pairs and not unseen:
        raise InputError(Fault("--tell", f"{text!r} names one cause at one place", EXAMPLE))
    reached = space.criterion(everything, pairs)
    lost = {frozenset(pair) for pair, power in zip(pairs, reached, strict=True) if power < LEVELS.least}
    hopeless = tuple(pair for pair in pairs[::2] if frozenset(pair) in lost)
    open_pairs = tuple(pair for pair in pairs if frozenset(pair) not in lost)
    words = advice(hopeless or pairs or [(unseen[0], e) for e in effects], prior.problem)
    return TellSpace(
        prior, at_zero, offered, space, open_pairs, asked, hopeless, tuple(unseen), words, search
    )


def plan_discrimination(prior: PriorInformation, text: str, count: int, search: Search) -> DiscriminationPlan:
    """`count` records out of the candidates that tell the causes of `text` apart. Raises InputError where
    the text names no two causes, or causes that these records cannot have."""
    space = tell_space(prior, text, search)
    check_count(count, len(space.offered.poses.q))
    if not space.pairs:
        return _plan(space, None, count)
    designs = [t_optimal(space.space, space.pairs, count, search), *_draws(space, count)]
    least = [float(space.space.criterion(space.space.measured(d), space.pairs).min()) for d in designs]
    best = int(np.argmax(least))  # exchanges end where no single one helps: some draw may be better
    return replace(_plan(space, take(space.offered, designs[best]), count), any_do=best > 0)


def plan_discrimination_in_time(
    prior: PriorInformation, text: str, seconds: float, search: Search, ways: Ways, dwell: float
) -> DiscriminationPlan:
    """The records that tell the causes of `text` apart best in a time; raises as `plan_discrimination`."""
    space = tell_space(prior, text, search)
    if not space.pairs:
        return _plan(space, None, 0)
    best, alone = in_time(space, ways, dwell, seconds)
    check_sessions(space, best, seconds, TELLS)
    made = _plan(space, best.drive.plan, len(best.drive.plan.poses))
    over = best.rate / alone.rate if alone.worth > TELLS else None
    return replace(made, over_poses=over, stops=best.stops)


def _plan(space: TellSpace, records: Campaign | None, count: int) -> DiscriminationPlan:
    """The plan of some records, and what random ones do."""
    found = DiscriminationPlan(
        records=records,
        count=count,
        noise=space.prior.noise,
        hardest=(),
        hopeless=space.hopeless,
        unseen=space.unseen,
        needed=None,
        separate_by=space.separate_by,
    )
    if records is None:
        return found
    data, draws = space.data(records), _draws(space, count)
    at_random = [space.space.measured(draw) for draw in draws]
    asked = tuple(min(_ways(space, two, data, draws), key=lambda way: way.plan) for two in space.asked)
    hardest = _hardest(space, data, draws)
    return replace(
        found,
        random=take(space.offered, draws[0]),
        worth=(space.worth_of(data), float(np.median([space.worth_of(d) for d in at_random]))),
        hardest=hardest,
        needed=_needed(hardest, count),
        asked=tuple(replace(pair, needed=_needed([pair], count)) for pair in asked),
    )


def _draws(space: TellSpace, count: int) -> list[Records]:
    """Some draws of as many random records."""
    return random_draws(len(space.space.rows), count, space.search.seed)


def _offered(prior: PriorInformation, text: str, search: Search) -> tuple[Campaign, list[list[Effect]]]:
    """Candidates that vary what the named causes depend on, and what each cause may be in them. Raises
    InputError where a cause is given or excluded."""
    causes = named_causes(text)
    everything = candidates(prior, 0, Factors(True, True, True), np.random.default_rng(search.seed))
    needed = factors(causes, replace(prior.problem, campaign=everything)).possible(search.driving)
    offered = candidates(prior, search.pool, needed, np.random.default_rng([search.seed, 21]), search.draw)
    problem = replace(prior.problem, campaign=offered)
    found = [[e for e in cause.effects(problem) if prior.is_open(e)] for cause in causes]
    known = [cause.text for cause, left in zip(causes, found, strict=True) if not left]
    if known:
        raise InputError(
            [Fault(f"--tell {one}", "is known: nothing is to be told", "leave it out") for one in known]
        )
    return offered, found


def _pairs(causes: Sequence[Sequence[Effect]], unseen: Sequence[Effect]) -> list[Pair]:
    """Every pair of different causes or places, both ways one after the other."""
    out: dict[frozenset[Effect], Pair] = {}
    every = (pair for first, second in combinations(causes, 2) for pair in product(first, second))
    for a, b in every:
        if a.key != b.key and a not in unseen and b not in unseen:
            out.setdefault(frozenset((a, b)), (a, b))
    return [way for a, b in out.values() for way in ((a, b), (b, a))]


def _hardest(space: TellSpace, data: Array, draws: Sequence[Records]) -> tuple[Discrimination, ...]:
    """Both ways of the pair with the least λ after data (P, P)."""
    k = int(np.argmin(space.space.criterion(data, space.pairs))) // 2 * 2
    return _ways(space, space.pairs[k : k + 2], data, draws)


def _ways(
    tell: TellSpace, pairs: Sequence[Pair], data: Array, draws: Sequence[Records]
) -> tuple[Discrimination, ...]:
    """λ of pairs now, after data (P, P), and after random records, the median of some draws."""
    space = tell.space
    plan = space.criterion(data, pairs)
    now = space.criterion(space.before, pairs) if space.before.any() else [None] * len(pairs)
    random = np.median([space.criterion(space.measured(draw), pairs) for draw in draws], axis=0)
    return tuple(
        Discrimination(*pair, None if n is None else float(n), float(r), float(p))
        for pair, n, r, p in zip(pairs, now, random, plan, strict=True)
    )


def _needed(hardest: Sequence[Discrimination], count: int) -> int | None:
    """Planned records for a λ of `LEVELS.mostly`, were each worth as much as one of this plan."""
    worst = min(hardest, key=lambda pair: pair.plan)
    now = worst.now or 0.0
    gain = (worst.plan - now) / count
    needed = (LEVELS.mostly - now) / gain if gain > 0 else np.inf
    return int(np.ceil(needed)) if needed < MOST_MEASURED else None


def advice(pairs: Sequence[Pair], problem: Problem) -> str:
    """What the effects themselves say tells them apart, but for what is known of the problem already."""
    read = {item.effect.key for item in given_facts(problem)}
    said = list(filter(None, (separation_beside(a.key, b.key, read, problem) for a, b in pairs)))
    return (
        "; ".join(dict.fromkeys(said))
        or "the drives' torques, a target on the link in question, another load"
    )
