"""What `[known]` says of campaigns that are compared: what is said of all and contradicted by none."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...campaign.known import KnownData
from ...campaign.problem import Problem
from ...effects.given import Exclusion, Given, exclusions, given_facts
from ..found import GivenFact
from ..telling.headline import listed

Said = Given | Exclusion


@dataclass(frozen=True)
class Known:
    """given: numbers of one campaign; excluded: causes that are not there; notes: what is kept to and what
    is not, in words."""

    given: tuple[Given, ...]
    excluded: tuple[Exclusion, ...]
    notes: tuple[str, ...]


def said_of_all(problems: Sequence[Problem]) -> list[list[Said]]:
    """Of each campaign, in one order, what is said of every one: numbers where they are known better than
    they usually err, and causes that are not there. Then how they changed is known too, and no change of them
    competes. Raises `InputError` as `given_facts`."""
    facts = [given_facts(problem) for problem in problems]
    causes = [exclusions(problem) for problem in problems]
    every = [[_same(own, fact) for own in facts] for fact in facts[0]]
    kept = [found for row in every if _surely(found := [one for one in row if one is not None], len(facts))]
    excluded = [one for one in causes[0] if all(one in own for own in causes)]
    return [[*(found[k] for found in kept), *excluded] for k in range(len(problems))]


def only(common: Iterable[Said], known: KnownData) -> KnownData:
    """Of a campaign's `[known]`, these facts alone."""
    facts = tuple(one.fact for one in common if isinstance(one, Given))
    exclude = tuple(one.text for one in common if isinstance(one, Exclusion))
    return known.model_copy(update={"facts": facts, "exclude": exclude})


def held_against(
    problems: Sequence[Problem], common: Sequence[Sequence[Said]], told: Sequence[Sequence[GivenFact]]
) -> list[Known]:
    """Of each campaign what holds, since the data of none contradict it. told: of each, in the order of
    `common`, what became of it beside that campaign's data; nothing of one that has too few poses."""
    refuted = {i for own in told for i, fact in enumerate(own) if not fact.obeyed}
    out = []
    for problem, own, facts in zip(problems, common, told, strict=True):
        kept = [one for i, one in enumerate(own) if i not in refuted]
        notes = [f"given and kept to{'' if any(told) else ', not tested'}: {_texts(kept)}"] if kept else []
        notes += [fact.sentence for fact in facts if not fact.obeyed]
        if others := [own[i] for i in sorted(refuted) if not facts or facts[i].obeyed]:
            notes.append(f"given and not used: {_texts(others)} (the data of another campaign contradict it)")
        every: list[Said] = [*given_facts(problem), *exclusions(problem)]
        if unused := [one for one in every if one not in own]:
            why = "a comparison uses what is said of every campaign, numbers within their usual error"
            notes.append(f"given and not used: {_texts(unused)} ({why})")
        given = tuple(one for one in kept if isinstance(one, Given))
        excluded = tuple(one for one in kept if isinstance(one, Exclusion))
        out.append(Known(given, excluded, tuple(notes)))
    return out


def _texts(said: Iterable[Said]) -> str:
    return listed([
        f"{one.effect.label}: {one.fact.said}" if isinstance(one, Given) else f"no {one.text.strip()}"
        for one in said
    ])  # fmt: skip


def _same(facts: Sequence[Given], fact: Given) -> Given | None:
    """What is said of the same number."""
    return next((one for one in facts if one.is_for(fact.effect)), None)


def _surely(found: Sequence[Given], count: int) -> bool:
    """Whether a number is said of each of so many campaigns, and well enough."""
    if len(found) < count:
        return False
    (param,) = found[0].effect.params
    return float(np.hypot.reduce([one.std for one in found])) <= param.typical
