"""The next records to tell rival causes apart, how far apart they then are, or why no poses do it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from ...campaign import Campaign
from ...diagnosis.result import FaultFound
from ...effects.base import Effect
from ...files.faults import Fault, InputError
from ...robot.kinematics import Array
from .candidates import candidates, ordered, payload_counts, take
from .causes import EXAMPLE, cause_places, factors, keys, label, split_causes
from .fedorov import Records, check_count, information
from .knowledge import Knowledge
from .rivals import Contest, Pair, contest, tell_apart

LEAST = 10.0  # λ below which a diagnosis hardly ever names the cause (blind tests: 3 to 8 %)
MOSTLY = 40.0  # λ from which it finds the cause always, and names it mostly
SURELY = 80.0  # λ from which it names the right one in most campaigns, and never the wrong one
MOST = 1000  # poses that anyone would measure for this
DRAWS = 25  # random plans behind a median


@dataclass(frozen=True)
class Told:
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
class TellPlan:
    """Records to tell causes apart, in the order to measure them; None where no poses do.

    hardest: both ways of the pair with the least λ after the plan; hopeless: pairs that all candidates
    together do not tell; unseen: effects that no pose shows beside geometry; needed: planned poses after
    which the hardest λ is `MOSTLY`; separate_by: measurements of another kind that tell the causes apart;
    faults: of the campaign's data.
    """

    records: Campaign | None
    count: int
    noise: str
    hardest: tuple[Told, ...]
    hopeless: tuple[Pair, ...]
    unseen: tuple[Effect, ...]
    needed: int | None
    separate_by: str
    faults: tuple[FaultFound, ...] = ()

    @property
    def least(self) -> float:
        """The smallest λ after the plan."""
        return min((told.plan for told in self.hardest), default=0.0)

    def to_json(self) -> dict[str, Any]:
        return {
            "kind": "tell",
            "n_poses": 0 if self.records is None else len(self.records.q),
            "payloads": {} if self.records is None else payload_counts(self.records),
            "noise": self.noise,
            "faults": [fault.to_json() for fault in self.faults],
            "told_apart": self.least >= LEAST and not self.hopeless and not self.unseen,
            "hardest": [told.to_json() for told in self.hardest],
            "hopeless": [{**keys(a), "rival": keys(b)} for a, b in self.hopeless],
            "unseen": [keys(effect) for effect in self.unseen],
            "poses_needed": self.needed,
            "separate_by": self.separate_by,
        }

    @property
    def text(self) -> str:
        lines = [f"No pose shows {label(effect)}." for effect in self.unseen]
        lines += [f"No poses tell {label(a)} from {label(b)}." for a, b in self.hopeless]
        if self.hardest:
            lines.append(
                f"λ, how far apart these causes are (below {LEAST:g} alike, above {SURELY:g} apart), if of"
            )
            lines.append(f"typical size ({self._sizes()}), with {self.noise}:")
            for told in self.hardest:
                now = "" if told.now is None else f"{told.now:.3g} now, "
                lines.append(
                    f"  {label(told.effect)} beside {label(told.rival)}: {now}{told.random:.3g} after "
                    f"{self.count} random poses, {told.plan:.3g} after this plan"
                )
            lines.append(self._meaning())
        if self.least < MOSTLY or self.hopeless or self.unseen:
            lines.append(f"Another kind of measurement tells more: {self.separate_by}.")
        return "\n".join(lines)

    def _sizes(self) -> str:
        params = [(e.label, e.params[0]) for told in self.hardest for e in (told.effect, told.rival)]
        sizes = {name: f"{p.name} {p.typical:g} {p.unit}".removesuffix(" 1") for name, p in params}
        return ", ".join(sizes.values())

    def _meaning(self) -> str:
        """λ in words; it goes with the square of the causes' size."""
        more = f"about {self.needed} planned poses" if self.needed else "more poses than anyone measures"
        if self.least >= SURELY:
            return "This plan tells them apart."
        if self.least >= MOSTLY:
            return "This plan tells them apart, mostly; smaller causes it may not."
        if self.least >= LEAST:
            return f"This plan may tell them apart; to be fairly sure takes {more}, or larger causes."
        return f"So few poses do not tell them apart: that takes {more}, or larger causes."


def plan_tell(known: Knowledge, text: str, count: int, pool: int, starts: int, seed: int) -> TellPlan:
    """`count` records out of about `pool` candidates that tell the causes of `text` apart. Raises InputError
    where the text names no two causes, or causes that these records cannot have."""
    named = split_causes(text)
    offered = candidates(known, pool, factors(named), np.random.default_rng([seed, 21]))
    check_count(count, len(offered.q))
    whole = replace(known.problem, campaign=offered)
    first, second = (cause_places(item, whole) for item in named)
    effects = list(dict.fromkeys([*first, *second]))
    given = tuple((effect, np.zeros(len(effect.params))) for effect in effects)
    field = contest(known.new(offered, given), known.measured(given))
    everything = field.before + information(field.rows)
    unseen = [effect for effect in effects if field.alone(everything, effect) < LEAST]
    pairs = _pairs(first, second, unseen)
    if not pairs and not unseen:
        raise InputError(Fault("--tell", f"{text!r} names one cause at one place", EXAMPLE))
    hopes = field.lambdas(everything, pairs)
    hopeless = [pair for pair, hope in zip(pairs, hopes, strict=True) if hope < LEAST]
    lost = {frozenset(pair) for pair in hopeless}
    open_pairs = [pair for pair in pairs if frozenset(pair) not in lost]
    advice = _advice(hopeless or pairs or [(unseen[0], e) for e in effects])
    hopeless = [pair for pair in pairs[::2] if frozenset(pair) in lost]
    if not open_pairs:
        return TellPlan(None, count, known.noise, (), tuple(hopeless), tuple(unseen), None, advice)
    chosen = tell_apart(field, open_pairs, count, starts, seed)
    hardest = _hardest(field, open_pairs, chosen, seed)
    return TellPlan(
        ordered(take(offered, chosen)),
        count,
        known.noise,
        hardest,
        tuple(hopeless),
        tuple(unseen),
        _needed(hardest, count),
        advice,
    )


def _pairs(first: Sequence[Effect], second: Sequence[Effect], unseen: Sequence[Effect]) -> list[Pair]:
    """Every pair of different causes or places, both ways one after the other."""
    out: dict[frozenset[Effect], Pair] = {}
    for a, b in product(first, second):
        if a.key != b.key and a not in unseen and b not in unseen:
            out.setdefault(frozenset((a, b)), (a, b))
    return [way for a, b in out.values() for way in ((a, b), (b, a))]


def _hardest(field: Contest, pairs: Sequence[Pair], chosen: Records, seed: int) -> tuple[Told, ...]:
    """Both ways of the pair with the least λ."""
    plan = field.lambdas(field.data(chosen), pairs)
    k = int(np.argmin(plan)) // 2 * 2
    both = pairs[k : k + 2]
    now = field.lambdas(field.before, both) if field.before.any() else [None, None]
    draws = [
        field.lambdas(
            field.data(np.random.default_rng([seed, 32, i]).integers(len(field.rows), size=len(chosen))), both
        )
        for i in range(DRAWS)
    ]
    random: Array = np.median(draws, axis=0)
    return tuple(
        Told(*pair, None if n is None else float(n), float(r), float(p))
        for pair, n, r, p in zip(both, now, random, plan[k : k + 2], strict=True)
    )


def _needed(hardest: Sequence[Told], count: int) -> int | None:
    """Planned records for a λ of `MOSTLY`, were each worth as much as one of this plan."""
    worst = min(hardest, key=lambda told: told.plan)
    now = worst.now or 0.0
    gain = (worst.plan - now) / count
    needed = (MOSTLY - now) / gain if gain > 0 else np.inf
    return int(np.ceil(needed)) if needed < MOST else None


def _advice(pairs: Sequence[Pair]) -> str:
    """What the effects themselves say tells them apart."""
    said = [text for a, b in pairs for text in (a.separate.get(b.cause), b.separate.get(a.cause)) if text]
    return (
        "; ".join(dict.fromkeys(said))
        or "the drives' torques, a target on the link in question, another load"
    )
