"""What `[known]` says of campaigns that are compared: what is said of all of them holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...campaign.problem import Problem
from ...effects.given import Exclusion, Given, exclusions, given_facts
from .words import listed


@dataclass(frozen=True)
class Known:
    """given: of each campaign the same numbers, each with its own value there; excluded: causes that are at
    none; notes: of each campaign, what is kept to and what is not."""

    given: tuple[tuple[Given, ...], ...]
    excluded: tuple[Exclusion, ...]
    notes: tuple[tuple[str, ...], ...]


def known_of(problems: Sequence[Problem]) -> Known:
    """What is said of every campaign, numbers where they are known better than they usually err: then how
    they changed is known too, and no change of them competes. Raises `InputError` as `given_facts`."""
    facts = [given_facts(problem) for problem in problems]
    causes = [exclusions(problem) for problem in problems]
    excluded = [one for one in causes[0] if all(one in own for own in causes)]
    every = [[_same(own, fact) for own in facts] for fact in facts[0]]
    kept = [found for row in every if _surely(found := [one for one in row if one is not None], len(facts))]
    given = [tuple(found[k] for found in kept) for k in range(len(facts))]
    notes = list[tuple[str, ...]]()
    for own, left_out, held in zip(facts, causes, given, strict=True):
        obeyed = [f"{g.effect.label}: {g.fact.said}" for g in held]
        obeyed += [f"no {one.text.strip()}" for one in left_out if one in excluded]
        unused = [f"{g.effect.label}: {g.fact.said}" for g in own if g not in held]
        unused += [f"no {one.text.strip()}" for one in left_out if one not in excluded]
        said = [f"given and kept to, not tested: {listed(obeyed)}"] if obeyed else []
        if unused:
            why = "a comparison uses what is said of every campaign, numbers within their usual error"
            said.append(f"given and not used: {listed(unused)} ({why})")
        notes.append(tuple(said))
    return Known(tuple(given), tuple(excluded), tuple(notes))


def _same(facts: Sequence[Given], fact: Given) -> Given | None:
    """What is said of the same number."""
    return next((one for one in facts if one.is_for(fact.effect)), None)


def _surely(found: Sequence[Given], count: int) -> bool:
    """Whether a number is said of each of so many campaigns, and well enough."""
    if len(found) < count:
        return False
    (param,) = found[0].effect.params
    return float(np.hypot.reduce([one.std for one in found])) <= param.typical
