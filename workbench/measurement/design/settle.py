"""The smallest campaign that settles what a diagnosis left ambiguous: every tie of a `result.json`, or one
that is said with the size that was found.

λ and what settles it are those of `ties`; what no record on offer settles is said, and left out.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...campaign import Campaign
from ...campaign.problem import Problem
from ...diagnosis.priors import PRIORS
from ...effects import catalogue
from ...effects.base import UNKNOWN, Effect
from ...effects.place import Where
from ...effects.records import PLACE, from_record, parse_effect
from ...effects.unnamed import unnamed
from ...files.faults import Fault, InputError, read_text
from ...identification.fit import Fit
from ...robot.kinematics import Array
from ...robot.schema import EffectRecord
from ..driving.ways import Ways
from .budget import Question, check_sessions, in_time
from .candidates import candidates, random_draws, random_rows, take
from .causes import (
    EXAMPLE,
    chance_of,
    has_size,
    label,
    named_causes,
    pairs_of,
    split_causes,
    split_ties,
    varied,
)
from .discrimination import advice
from .discrimination_plan import MOST_MEASURED, Discrimination, DiscriminationPlan
from .fedorov import Records, Search
from .prior_information import PriorInformation, ValuedEffects
from .shown import check_shown, with_hope, with_shown
from .t_optimal import DesignSpace, Pair, design_space
from .ties import (
    Attempts,
    Settling,
    Tie,
    as_found,
    at_zero,
    best_records,
    fewest,
    least,
    sites_of,
    tie_between,
    wherever,
)

POSES = Attempts(first=24, fewest=12, most=120, times=5, margin=1.05)
PLACES = (*PLACE, "order")
NOTHING = 0.01  # probability below which a plan brings nothing to what is true


def is_found(text: str) -> bool:
    """Whether `--tell` says what a diagnosis found: a `result.json`, or first causes with their sizes."""
    return text.endswith(".json") or any(has_size(cause) for cause in _first_causes(text))


def _first_causes(text: str) -> list[str]:
    """The first cause of each tie."""
    return [cause for tie in split_ties(text) for cause in split_causes(tie)[:1]]


def found_by(tell: str | None, problem: Problem) -> list[Effect]:
    """The effects that a diagnosis found, as far as `--tell` says them. Raises InputError."""
    if tell is None or not is_found(tell):
        return []
    if not tell.endswith(".json"):
        return [parse_effect(chance_of(cause)[0], problem)[0] for cause in _first_causes(tell)]
    with _result(Path(tell), problem) as causes:
        return [_effect(one, problem)[0] for one in causes if one["cause"] != UNKNOWN]


@dataclass(frozen=True, eq=False)
class SettleSpace(Question):
    """Candidate records and the ties that they may settle; lost: of those that none on offer settle, the
    cause and a rival; asked: every tie that was said; notes: what is odd in them."""

    prior: PriorInformation
    effects: ValuedEffects
    offered: Campaign
    space: DesignSpace
    ties: tuple[Tie, ...]
    asked: tuple[Tie, ...]
    lost: tuple[Pair, ...]
    notes: tuple[str, ...]
    search: Search

    def looking_at(self, names: Collection[str]) -> SettleSpace:
        offered = self.offered.looking_at(names)
        return replace(self, offered=offered, space=self.of(offered))

    def of(self, records: Campaign) -> DesignSpace:
        """The space of some records."""
        rows = self.prior.of_records(records, self.effects).on(self.space.names)
        return replace(self.space, rows=rows)

    def chosen(self, among: Records, count: int) -> Records:
        """The records (count,) after which what is true of the hardest tie is believed most."""
        part = replace(self.space, rows=self.space.rows[among])
        return among[best_records(Settling(part, self.ties), as_found(part, self.ties), count, self.search)]

    def worth(self, records: Campaign) -> float:
        """By how much more what is true of the hardest tie is believed."""
        settling = Settling(self.space, self.ties)
        return settling.believed(self.of(records).everything) - settling.believed(self.space.before)


def settle_space(prior: PriorInformation, text: str, search: Search) -> SettleSpace:
    """Candidates that settle every tie of a `result.json`, or those of causes with their sizes, each beside
    others without. Raises InputError where there is no tie."""
    if prior.fit is None:
        what = "needs the campaign that was diagnosed, not the robot alone"
        raise InputError(Fault(f"--tell {text}", what, "workbench plan campaign.toml --tell result.json"))
    said = [] if text.endswith(".json") else split_ties(text)
    ties = [tie_said(one, prior.fit) for one in said] or ties_of(Path(text), prior.fit)
    valued = at_zero(ties)
    factors = varied(effect for effect, _ in valued).possible(search.driving)
    rng = np.random.default_rng([search.seed, 21])
    offered = candidates(prior, search.pool, factors, rng, search.draw)
    space = design_space(prior.of_records(offered, valued), prior.of_campaign(valued))
    for one, tie in zip(said, ties, strict=False):
        # of what a diagnosis says with its probability, some may not show in the poses on offer: no fault
        rivals = _rivals_said(one, tie.effect, wherever(prior.problem))
        sites = [places for places, chance in rivals if chance is None]
        check_shown(space, [[tie.effect], *sites], prior)
    asked = tuple(tie for tie in (with_shown(space, tie, prior.fit) for tie in ties) if tie.rivals)
    if not asked:
        check_shown(space, [tie.rivals for tie in ties], prior)
    every = np.arange(len(space.rows))
    most = space.measured(every, MOST_MEASURED)
    parted = [with_hope(space, most, tie) for tie in asked]
    some = tuple(tie for tie, _ in parted if tie.rivals)
    lost = tuple((tie.effect, rival) for tie, gone in parted for rival in gone)
    notes = tuple(filter(None, map(_too_large, asked)))
    return SettleSpace(prior, valued, offered, space, some, asked, lost, notes, search)


def plan_settling(
    prior: PriorInformation, text: str, count: int | None, search: Search
) -> DiscriminationPlan:
    """The fewest records after which the ties of `text` are settled, or `count`; raises as `settle_space`."""
    space = settle_space(prior, text, search)
    if not space.ties:
        return _plan(space, None)
    attempts = POSES if count is None else replace(POSES, first=count, times=1)
    chosen, _ = fewest(space.space, space.ties, search, attempts)
    draws = random_draws(len(space.space.rows), len(chosen), search.seed)
    made = _plan(space, take(space.offered, chosen))
    return replace(made, any_do=any(np.array_equal(draw, chosen) for draw in draws))


def plan_settling_in_time(
    prior: PriorInformation, text: str, seconds: float, search: Search, ways: Ways, dwell: float
) -> DiscriminationPlan:
    """The records after which what is true of the ties of `text` is believed most, in a time; raises as
    `settle_space`."""
    space = settle_space(prior, text, search)
    if not space.ties:
        return _plan(space, None)
    best, alone = in_time(space, ways, dwell, seconds)
    check_sessions(space, best, seconds, NOTHING)
    over = best.rate / alone.rate if alone.worth > NOTHING else None
    return replace(_plan(space, best.drive.plan), over_poses=over, stops=best.stops)


def _plan(space: SettleSpace, records: Campaign | None) -> DiscriminationPlan:
    """The plan of some records, and what random ones do."""
    pairs = [(tie.effect, rival) for tie in space.asked for rival in tie.rivals]
    words = advice(pairs, space.prior.problem)
    made = DiscriminationPlan(
        None, 0, space.prior.noise, (), space.lost, (), None, words, notes=space.notes, found=True
    )
    if records is None:
        return made
    count, some = len(records.poses), space.ties
    order = random_rows(len(space.space.rows), count, space.search.seed)
    told = _Told(space.of(records), space.space.measured(order))
    all_ties = Settling(told.plan, some)
    return replace(
        made,
        records=records,
        count=count,
        hardest=tuple(told.of(tie, tie.rivals[0]) for tie in some),
        asked=tuple(
            told.of(tie.beside(rival.key), rival) for tie in space.asked for rival in _first_forms(tie)
        ),
        needed=told.needed(some),
        random=take(space.offered, order),
        worth=(all_ties.power(told.plan.everything), all_ties.power(told.random)),
    )


@dataclass(frozen=True, eq=False)
class _Told:
    """What the records of a plan tell, and random ones. plan: the space of these records alone; random: (P,
    P) information of the campaign and of as many random ones."""

    plan: DesignSpace
    random: Array

    def of(self, tie: Tie, rival: Effect) -> Discrimination:
        """The cause beside its hardest rival, and the planned records that settle it."""
        now, random, plan = (
            least(self.plan, data, tie) for data in (self.plan.before, self.random, self.plan.everything)
        )
        return Discrimination(tie.effect, rival, now, random, plan, self.needed([tie]))

    def needed(self, ties: Sequence[Tie]) -> int | None:
        return Settling(self.plan, ties).needed(np.arange(len(self.plan.rows)))


def _first_forms(tie: Tie) -> list[Effect]:
    """Of each rival the first of its forms."""
    return list({rival.key: rival for rival in reversed(tie.rivals)}.values())[::-1]


def _too_large(tie: Tie) -> str:
    """A word on a size that no cause of its kind has, where a person said it: a diagnosis has its
    probability beside."""
    times = float(np.abs(tie.size).max())
    if times <= PRIORS.largest or tie.effect.key in tie.chances:
        return ""
    return (
        f"{label(tie.effect)} is said to be {times:.3g} times its usual size; beyond {PRIORS.largest:g} "
        "times nothing passes for a cause: is the number right?"
    )


def tie_said(text: str, fit: Fit) -> Tie:
    """The tie of `cause:place,size,rival:place,...`, each with its probability where that is known; those
    without a name are rivals only by theirs. Raises InputError."""
    first, chance = chance_of(split_causes(text)[0])
    problem = fit.model.problem
    effect, size = parse_effect(first, problem)
    chances = {} if chance is None else {effect.key: chance}
    rivals: list[Effect] = []
    for places, chance in _rivals_said(text, effect, wherever(problem)):
        chances |= {} if chance is None else {one.key: chance for one in places}
        known = fit.model.given
        rivals += [e for e in places if e.cause != UNKNOWN and not any(item.is_for(e) for item in known)]
    if not rivals:
        raise InputError(Fault("--tell", f"{text!r} has no rival with a name", EXAMPLE))
    return tie_between(fit, effect, size, tuple(rivals), chances)


def _rivals_said(text: str, effect: Effect, problem: Problem) -> list[tuple[Sequence[Effect], float | None]]:
    """Everywhere each further cause of a text may sit, and its probability where that is said. Raises
    InputError."""
    others = [chance_of(cause) for cause in split_causes(text)[1:]]
    if not others:
        raise InputError(Fault("--tell", f"{text!r} names one cause, not two", EXAMPLE))
    return [(_places_of(effect, cause, problem), chance) for cause, chance in others]


def _places_of(effect: Effect, rival: str, problem: Problem) -> Sequence[Effect]:
    """Everywhere a rival may sit; the effect's own place and size are read already. Raises InputError."""
    if rival.partition(":")[0] != UNKNOWN:
        return named_causes(f"{effect.cause},{rival}")[1].effects(problem)
    said = {key: value for key, _, value in pairs_of(rival)}
    found = [one for one in unnamed(problem) if {k: str(v) for k, v in one.where.keys().items()} == said]
    if not found:
        raise InputError(Fault(f"--tell {rival}", "nothing without a name sits there", EXAMPLE))
    return found


def ties_of(path: Path, fit: Fit) -> list[Tie]:
    """What a `result.json` left ambiguous, with the rivals that have a name. Raises InputError."""
    with _result(path, fit.model.problem) as causes:
        found = [tie for one in causes if one["status"] != "named" and (tie := _tie(one, fit))]
    if not found:
        what = "leaves no cause ambiguous beside another that has a name"
        raise InputError(
            Fault(str(path), what, "there is nothing to settle; plan for accuracy without --tell")
        )
    return found


@contextmanager
def _result(path: Path, problem: Problem) -> Iterator[list[dict[str, Any]]]:
    """The causes of a `result.json` of this robot. Raises InputError, also where what is read of them is not
    there."""
    try:
        told = json.loads(read_text(path))
        causes, own = told["causes"], problem.robot.name
        if (robot := told.get("robot", own)) != own:
            raise InputError(
                Fault(str(path), f"is of {robot}, the campaign of {own}", "name this robot's result")
            )
        yield causes
    except (json.JSONDecodeError, KeyError, TypeError, AttributeError):
        raise InputError(Fault(str(path), "is no result.json of a diagnosis", "name that of --out")) from None


def _effect(one: dict[str, Any], problem: Problem) -> tuple[Effect, Array]:
    """A cause of a `result.json`, and its size (p,): of several forms of it, the one that shows most."""
    said = {p["name"]: p for p in one["parameters"]}
    where = {key: one[key] for key in PLACES if key in one}
    form = one.get("variant") or _clearest(one["cause"], said, problem)
    effect, _ = from_record(EffectRecord(cause=one["cause"], variant=form, **where), problem)
    # a further part of the law is said with its form, as in "amplitude (2)"
    own = {name: said.get(f"{name} ({effect.variant})", said.get(name)) for name in effect.names}
    return effect, effect.given({name: float(p["value"]) for name, p in own.items() if p is not None})


def _clearest(cause: str, said: dict[str, Any], problem: Problem) -> str:
    """Of a result that does not tell the form: that with the number farthest from none for its spread; none
    where the first has it."""
    sure = {name: abs(p["value"]) / p["std"] for name, p in said.items() if p["value"] and p["std"]}
    places = catalogue()[cause].places(problem) if cause in catalogue() else ()
    own = {form.variant: max((sure.get(name, 0.0) for name in form.names), default=0.0) for form in places}
    clearest = max(own, key=lambda variant: own[variant], default="")
    return "" if clearest == next(iter(own), "") else clearest


def _tie(one: dict[str, Any], fit: Fit) -> Tie | None:
    if one["cause"] == UNKNOWN:
        return None
    effect, size = _effect(one, fit.model.problem)
    others = (*one["rivals"], *one.get("faint", ()))
    chances = {(r["cause"], _place(r)): float(r["probability"]) for r in others}
    rivals = sites_of(chances, fit)
    chances[effect.key] = float(one.get("probability", 1 - sum(chances.values())))
    return tie_between(fit, effect, size, rivals, chances) if rivals else None


def _place(record: dict[str, Any]) -> Where:
    return Where(**{key: record[key] for key in PLACE if key in record})
