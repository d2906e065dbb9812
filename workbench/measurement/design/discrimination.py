"""The next records to discriminate between rival causes, how far apart they then are, or why none do it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product
from typing import Any

import numpy as np

from ...campaign import Campaign
from ...diagnosis.result import FaultFound
from ...effects import separation
from ...effects.base import Effect
from ...files.faults import Fault, InputError
from ...robot.kinematics import Array
from ..driving.drive import Drive
from ..driving.reach import Reach
from ..driving.ways import Ways
from .accuracy import DRAWS
from .budget import Question, in_time, levels_of
from .candidates import Factors, candidates, payload_counts, take
from .causes import EXAMPLE, factors, keys, label, named_causes
from .fedorov import Records, Search, check_count, information
from .prior_information import PriorInformation, ValuedEffects
from .t_optimal import DesignSpace, Pair, design_space, t_optimal

MOST_MEASURED = 1000  # poses that anyone would measure for this


@dataclass(frozen=True)
class Power:
    """λ and what a diagnosis makes of it, as the blind study has it."""

    least: float = 10.0  # below, it hardly ever names the cause (3 to 8 % of the cases)
    mostly: float = 40.0  # from here it finds the cause always, and names it mostly
    surely: float = 80.0  # from here it names the right one in most campaigns, and never the wrong one


LEVELS = Power()


@dataclass(frozen=True)
class Discrimination:
    """λ of a cause beside its rival: now (None without a campaign), after random records, after the plan."""

    effect: Effect
    rival: Effect
    now: float | None
    random: float
    plan: float

    def to_json(self) -> dict[str, Any]:
        return {
            **keys(self.effect),
            "rival": keys(self.rival),
            "lambda_now": self.now,
            "lambda_random": self.random,
            "lambda_plan": self.plan,
        }


@dataclass(frozen=True)
class DiscriminationPlan:
    """Records to tell causes apart, in the order to measure them; None where no poses do.

    hardest: both ways of the pair with the least λ after the plan; hopeless: pairs that all candidates
    together do not tell; unseen: effects that no pose shows beside geometry; needed: planned poses after
    which the hardest λ is `LEVELS.mostly`; separate_by: measurements of another kind that tell them apart;
    random: as many random records; faults: of the campaign's data; reach: the robot in its cell; drive: how
    they are driven, random_s: [s] that driving the random ones takes; over_poses, stops: as of an
    `AccuracyPlan`; found: the causes have the size in which they were found, and each stands beside its
    hardest rival.
    """

    records: Campaign | None
    count: int
    noise: str
    hardest: tuple[Discrimination, ...]
    hopeless: tuple[Pair, ...]
    unseen: tuple[Effect, ...]
    needed: int | None
    separate_by: str
    random: Campaign | None = None
    faults: tuple[FaultFound, ...] = ()
    reach: Reach | None = None
    drive: Drive | None = None
    random_s: float | None = None
    over_poses: float | None = None
    stops: int = 0
    found: bool = False

    @property
    def gain(self) -> float | None:
        """λ per hour over that of random records."""
        if self.drive is None or self.random_s is None:
            return None
        worst = min(self.hardest, key=lambda pair: pair.plan)
        now = worst.now or 0.0
        return (worst.plan - now) / self.drive.total_s / max((worst.random - now) / self.random_s, 1e-12)

    def with_drive(self, drive: Drive, random: Drive) -> DiscriminationPlan:
        """In the order of a drive; random: that of as many random records."""
        return replace(self, records=drive.own, drive=drive, random_s=random.total_s)

    @property
    def least(self) -> float:
        """The smallest λ after the plan."""
        return min((pair.plan for pair in self.hardest), default=0.0)

    def to_json(self) -> dict[str, Any]:
        return {
            "kind": "tell",
            "n_poses": 0 if self.records is None else len(self.records.poses.q),
            "payloads": {} if self.records is None else payload_counts(self.records),
            "noise": self.noise,
            "faults": [fault.to_json() for fault in self.faults],
            "told_apart": self.least >= LEVELS.least and not self.hopeless and not self.unseen,
            "hardest": [pair.to_json() for pair in self.hardest],
            "hopeless": [{**keys(a), "rival": keys(b)} for a, b in self.hopeless],
            "unseen": [keys(effect) for effect in self.unseen],
            "poses_needed": self.needed,
            "separate_by": self.separate_by,
            "drive": None if self.drive is None else self.drive.to_json(),
            "information_per_hour_over_random": self.gain,
            "information_per_hour_over_poses_alone": self.over_poses,
            "stops_on_the_way": self.stops,
        }

    @property
    def headline(self) -> str:
        """In one sentence."""
        time = "" if self.drive is None else f" in about {self.drive.total_s / 60:.0f} min"
        return f"{self.count} poses{time}: {self._meaning()}"

    @property
    def lines(self) -> list[str]:
        """What it brings."""
        drive = [] if self.drive is None else self.drive.text.split("\n")
        return [line.strip() for line in self.text.split("\n") if line not in drive]

    @property
    def text(self) -> str:
        lines = [f"No pose shows {label(effect)}." for effect in self.unseen]
        lines += [f"No poses tell {label(a)} from {label(b)}." for a, b in self.hopeless]
        if self.hardest:
            alike, apart = f"below {LEVELS.least:g} alike", f"above {LEVELS.surely:g} apart"
            lines.append(f"λ, how far apart these causes are ({alike}, {apart}), if of")
            size = "the size that was found" if self.found else f"typical size ({self._sizes()})"
            lines.append(f"{size}, with {self.noise}:")
            for pair in self.hardest:
                now = "" if pair.now is None else f"{pair.now:.3g} now, "
                lines.append(
                    f"  {label(pair.effect)} beside {label(pair.rival)}: {now}{pair.random:.3g} after "
                    f"{self.count} random poses, {pair.plan:.3g} after this plan"
                )
            lines.append(self._meaning())
        if self.least < LEVELS.mostly or self.hopeless or self.unseen:
            lines.append(f"Another kind of measurement tells more: {self.separate_by}.")
        if self.drive is not None:
            lines.append(self.drive.text)
        if self.gain is not None:
            lines.append(
                f"In the same time it tells {self.gain:.1f} times as much as random poses (λ per hour)."
            )
        return "\n".join(lines)

    def _sizes(self) -> str:
        params = [(e.label, e.params[0]) for pair in self.hardest for e in (pair.effect, pair.rival)]
        sizes = {name: f"{p.name} {p.typical:g} {p.unit}".removesuffix(" 1") for name, p in params}
        return ", ".join(sizes.values())

    def _meaning(self) -> str:
        """λ in words; it goes with the square of the causes' size."""
        more = f"about {self.needed} planned poses" if self.needed else "more poses than anyone measures"
        if self.least >= LEVELS.surely:
            return "This plan tells them apart."
        if self.least >= LEVELS.mostly:
            return "This plan tells them apart, mostly; smaller causes it may not."
        if self.least >= LEVELS.least:
            return f"This plan may tell them apart; to be fairly sure takes {more}, or larger causes."
        return f"So few poses do not tell them apart: that takes {more}, or larger causes."


@dataclass(frozen=True, eq=False)
class TellSpace(Question):
    """Candidate records, the pairs of causes that they may tell apart, and what they cannot."""

    prior: PriorInformation
    effects: ValuedEffects
    offered: Campaign
    space: DesignSpace
    pairs: tuple[Pair, ...]
    hopeless: tuple[Pair, ...]
    unseen: tuple[Effect, ...]
    separate_by: str
    search: Search

    @cached_property
    def levels(self) -> Records:  # type: ignore[override]
        return levels_of(self.offered)

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
        now = float(self.space.criterion(self.space.before, self.pairs).min())
        return float(self.space.criterion(self.data(records), self.pairs).min()) - now


def tell_space(prior: PriorInformation, text: str, search: Search) -> TellSpace:
    """Candidates that tell the causes of `text` apart. Raises InputError where the text names no two causes,
    or causes that these records cannot have."""
    offered, causes = _offered(prior, text, search)
    effects = list(dict.fromkeys(effect for cause in causes for effect in cause))
    at_zero = tuple((effect, np.zeros(len(effect.params))) for effect in effects)
    space = design_space(prior.of_records(offered, at_zero), prior.of_campaign(at_zero))
    everything = space.before + information(space.rows)
    unseen = [effect for effect in effects if space.alone(everything, effect) < LEVELS.least]
    pairs = _pairs(causes, unseen)
    if not pairs and not unseen:
        raise InputError(Fault("--tell", f"{text!r} names one cause at one place", EXAMPLE))
    reached = space.criterion(everything, pairs)
    lost = {frozenset(pair) for pair, power in zip(pairs, reached, strict=True) if power < LEVELS.least}
    hopeless = tuple(pair for pair in pairs[::2] if frozenset(pair) in lost)
    open_pairs = tuple(pair for pair in pairs if frozenset(pair) not in lost)
    words = advice(hopeless or pairs or [(unseen[0], e) for e in effects])
    return TellSpace(prior, at_zero, offered, space, open_pairs, hopeless, tuple(unseen), words, search)


def plan_discrimination(prior: PriorInformation, text: str, count: int, search: Search) -> DiscriminationPlan:
    """`count` records out of the candidates that tell the causes of `text` apart. Raises InputError where
    the text names no two causes, or causes that these records cannot have."""
    space = tell_space(prior, text, search)
    check_count(count, len(space.offered.poses.q))
    if not space.pairs:
        return _plan(space, None, count)
    chosen = t_optimal(space.space, space.pairs, count, search)
    return _plan(space, take(space.offered, chosen), count)


def plan_discrimination_in_time(
    prior: PriorInformation, text: str, seconds: float, search: Search, ways: Ways, dwell: float
) -> DiscriminationPlan:
    """The records that tell the causes of `text` apart best in a time; raises as `plan_discrimination`."""
    space = tell_space(prior, text, search)
    if not space.pairs:
        return _plan(space, None, 0)
    best, alone = in_time(space, ways, dwell, seconds)
    made = _plan(space, best.drive.plan, len(best.drive.plan.poses))
    return replace(made, over_poses=best.rate / max(alone.rate, 1e-300), stops=best.stops)


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
    hardest = _hardest(space.space, space.pairs, space.data(records), count, space.search.seed)
    some = np.random.default_rng([space.search.seed, 23]).permutation(len(space.space.rows))[:count]
    random = take(space.offered, some)
    return replace(found, random=random, hardest=hardest, needed=_needed(hardest, count))


def _offered(prior: PriorInformation, text: str, search: Search) -> tuple[Campaign, list[list[Effect]]]:
    """Candidates that vary what the named causes depend on, and what each cause may be in them. Raises
    InputError where a cause is given or excluded."""
    causes = named_causes(text)
    everything = candidates(prior, 0, Factors(True, True, True), np.random.default_rng(search.seed))
    needed = replace(factors(causes, replace(prior.problem, campaign=everything)), pull=search.pull)
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


def _hardest(
    space: DesignSpace, pairs: Sequence[Pair], data: Array, count: int, seed: int
) -> tuple[Discrimination, ...]:
    """Both ways of the pair with the least λ after data (P, P) of `count` records."""
    plan = space.criterion(data, pairs)
    k = int(np.argmin(plan)) // 2 * 2
    both = pairs[k : k + 2]
    now = space.criterion(space.before, both) if space.before.any() else [None, None]
    draws = []
    for draw in range(DRAWS):
        at_random = np.random.default_rng([seed, 32, draw]).integers(len(space.rows), size=count)
        draws.append(space.criterion(space.measured(at_random), both))
    random: Array = np.median(draws, axis=0)
    return tuple(
        Discrimination(*pair, None if n is None else float(n), float(r), float(p))
        for pair, n, r, p in zip(both, now, random, plan[k : k + 2], strict=True)
    )


def _needed(hardest: Sequence[Discrimination], count: int) -> int | None:
    """Planned records for a λ of `LEVELS.mostly`, were each worth as much as one of this plan."""
    worst = min(hardest, key=lambda pair: pair.plan)
    now = worst.now or 0.0
    gain = (worst.plan - now) / count
    needed = (LEVELS.mostly - now) / gain if gain > 0 else np.inf
    return int(np.ceil(needed)) if needed < MOST_MEASURED else None


def advice(pairs: Sequence[Pair]) -> str:
    """What the effects themselves say tells them apart."""
    said = list(filter(None, (separation(a.cause, b.cause) for a, b in pairs)))
    return (
        "; ".join(dict.fromkeys(said))
        or "the drives' torques, a target on the link in question, another load"
    )
