"""Records that discriminate between rival causes: how far apart these then are, or why none do it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ...campaign import Campaign
from ...effects.base import Effect
from ...report.numbers import MISSING, significant
from ..driving.block import Drive
from .candidates import payload_counts
from .causes import keys, label
from .driven_plan import DrivenPlan
from .t_optimal import Pair


@dataclass(frozen=True)
class Power:
    """λ beside the hardest rival, and what a diagnosis makes of it.

    Of faults drawn as in the blind study these were named rightly: at 20 22 of 41, at 40 31 of 39, at 80 33
    of 37, and in none of them another one (`benchmarks/results/power.json`).
    """

    least: float = 10.0  # below, it hardly ever names the cause (3 to 8 % of the blind study's cases)
    mostly: float = 40.0  # from here it names the cause in four of five campaigns
    surely: float = 80.0  # and here in eight of nine
    found: str = "about four of five such causes are named, and one in a hundred wrongly"


LEVELS = Power()
TELLS = 1.0  # λ below which a plan tells nothing
MOST_MEASURED = 1000  # poses that anyone would measure for this


@dataclass(frozen=True)
class Discrimination:
    """λ of a cause beside its rival: now (None without a campaign), after random records, after the plan;
    needed: planned records that tell these two (None: more than anyone measures, or not worked out)."""

    effect: Effect
    rival: Effect
    now: float | None
    random: float
    plan: float
    needed: int | None = None

    def to_json(self) -> dict[str, Any]:
        return {
            **keys(self.effect),
            "rival": keys(self.rival),
            "lambda_now": self.now,
            "lambda_random": self.random,
            "lambda_plan": self.plan,
        }

    @property
    def row(self) -> list[str]:
        """Cause, rival, λ now, after random records and after the plan, and the records that tell them."""
        now = MISSING if self.now is None else significant(self.now)
        needed = f"more than {MOST_MEASURED}" if self.needed is None else f"{self.needed}"
        names = [label(self.effect), label(self.rival)]
        return [*names, now, significant(self.random), significant(self.plan), needed]


@dataclass(frozen=True)
class DiscriminationPlan(DrivenPlan):
    """Records to tell causes apart, in the order to measure them; None where no poses do.

    hardest: both ways of the pair with the least λ after the plan; hopeless: pairs that all candidates
    together do not tell; unseen: effects that no pose shows beside geometry; needed: planned poses after
    which the hardest λ is `LEVELS.mostly`; separate_by: measurements of another kind that tell them apart;
    random: as many random records; found: the causes have the size in which they were found, and each stands
    beside its hardest rival. asked: every two causes that were asked for, in their hardest places, with the
    planned poses that tell them; worth: what the plan brings, and random records: of ties that were found
    the probability that they are settled, else λ of what is hardest after each; any_do: no chosen records
    did better than random ones, which these are; notes: what is odd in what was asked.
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
    found: bool = False
    asked: tuple[Discrimination, ...] = ()
    worth: tuple[float, float] | None = None
    any_do: bool = False
    notes: tuple[str, ...] = ()

    @property
    def gain(self) -> float | None:
        """What it brings per hour over random records; None where these bring nothing."""
        if self.drive is None or self.random_s is None or self.worth is None:
            return None
        plan, random = self.worth
        return plan / self.drive.total_s / (random / self.random_s) if random > 0 else None

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
            "told_apart": self._told_apart and not self.hopeless and not self.unseen,
            "hardest": [pair.to_json() for pair in self.hardest],
            "hopeless": [{**keys(a), "rival": keys(b)} for a, b in self.hopeless],
            "unseen": [keys(effect) for effect in self.unseen],
            "asked": [{**pair.to_json(), "poses_needed": pair.needed} for pair in self.asked],
            "worth": None if self.worth is None else dict(zip(("plan", "random"), self.worth, strict=True)),
            "any_poses_do": self.any_do,
            "notes": list(self.notes),
            "poses_needed": self.needed,
            "separate_by": self.separate_by,
            **self.drive_json(),
        }

    @property
    def headline(self) -> str:
        """In one sentence."""
        return f"{self.count} poses{self.time}: {self._meaning()}"

    @property
    def lines(self) -> list[str]:
        """What it brings."""
        drive = [] if self.drive is None else self.drive.text.split("\n")
        return [line.strip() for line in self.text.split("\n") if line not in drive]

    @property
    def text(self) -> str:
        lines = [f"{note[:1].upper()}{note[1:]}" for note in self.notes]
        lines += [f"No pose shows {label(effect)}." for effect in self.unseen]
        lines += [f"No poses tell {label(a)} from {label(b)}." for a, b in self.hopeless]
        if self.hardest:
            lines.append(self._of_lambda())
            for pair in self.hardest:
                now = "" if pair.now is None else f"{significant(pair.now)} now, "
                lines.append(
                    f"  {label(pair.effect)} beside {label(pair.rival)}: {now}{significant(pair.random)} "
                    f"after {self.count} random poses, {significant(pair.plan)} after this plan"
                )
            lines += [self._meaning(), *self._beside_random(), *self._others()]
        if self.any_do:
            lines.append("No chosen poses tell more than random ones, which these are: any poses do.")
        enough = self.settles if self.found else self.least >= LEVELS.mostly
        if not enough or self.hopeless or self.unseen:
            lines.append(f"Another kind of measurement tells more: {self.separate_by}.")
        if self.drive is not None:
            lines += [self.drive.text, *self.not_measured]
        if self.gain is not None and not self.any_do:
            of = "probability to settle it, per hour" if self.found else "λ of the hardest pair, per hour"
            lines.append(f"In the same time it tells {self.gain:.1f} times as much as random poses ({of}).")
        return "\n".join(lines)

    def _beside_random(self) -> list[str]:
        """What random poses bring, by what counts: λ of the pair that the plan leaves hardest is not all."""
        if self.worth is None:
            return []
        plan, random = self.worth
        if self.found:
            words = f"It is settled after this plan with a probability of {plan:.2f}"
            return [f"{words}, after as many random poses of {random:.2f}."]
        words = f"To the pair that is hardest for them random poses bring a λ of {significant(random)}"
        return [f"{words}, this plan {significant(plan)}."] if len(self.asked) > 1 else []

    def _others(self) -> list[str]:
        """Every two causes that were asked for, where these are more than two, a line each."""
        if len(self.asked) < 2:
            return []
        lines = ["Every two causes that were asked for (λ now, after random poses, after this plan; poses):"]
        for pair in self.asked:
            effect, rival, now, random, plan, needed = pair.row
            lines.append(f"  {effect} beside {rival}: {now}, {random}, {plan}; poses to tell: {needed}")
        return lines

    @property
    def settles(self) -> bool:
        """Of causes that were found: whether a diagnosis is expected to name what is true after it."""
        return self.needed is not None and self.needed <= self.count

    @property
    def _told_apart(self) -> bool:
        return self.settles if self.found else self.least >= LEVELS.least

    def _of_lambda(self) -> str:
        """What λ is. Of causes that were found it is no matter of its size alone: a real machine is off every
        form, and one cause is likelier than another before the data."""
        if self.found:
            return (
                "λ, how far apart these causes are, of the size that was found and exactly of their form, "
                f"with {self.noise} (what settles a tie are also the odds between the causes so far, and how "
                "far real ones are off their forms):"
            )
        alike, apart = f"below {LEVELS.least:g} alike", f"above {LEVELS.surely:g} apart"
        of = f"if of typical size ({self._sizes()}), with {self.noise}"
        return f"λ, how far apart these causes are ({alike}, {apart}), {of}:"

    def _sizes(self) -> str:
        params = [(e.label, e.params[0]) for pair in self.hardest for e in (pair.effect, pair.rival)]
        sizes = {name: f"{p.name} {p.typical:g} {p.unit}".removesuffix(" 1") for name, p in params}
        return ", ".join(sizes.values())

    def _meaning(self) -> str:
        """λ in words; it goes with the square of the causes' size."""
        more = f"about {self.needed} planned poses" if self.needed else "more poses than anyone measures"
        if self.found and self.settles:
            return "This plan is expected to settle it."
        if self.found:
            return f"This plan is not expected to settle it: that takes {more}."
        if self.least >= LEVELS.surely:
            return f"This plan tells them apart. In simulated campaigns {LEVELS.found}."
        if self.least >= LEVELS.mostly:
            return f"This plan tells them apart, mostly ({LEVELS.found}); smaller causes it may not."
        if self.least >= LEVELS.least:
            return f"This plan may tell them apart; to be fairly sure takes {more}, or larger causes."
        return f"So few poses do not tell them apart: that takes {more}, or larger causes."
