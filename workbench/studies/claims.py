"""Sentences of a page as conditions on its numbers: how often each holds, and whether it may be said."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ..report.study import Stand
from .draws import Draws

Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Claim:
    """name: how a story asks for it; words: the sentence in short, for the list of claims; holds: from the
    numbers of the run, with those of one draw in their place."""

    name: str
    words: str
    holds: Callable[[Numbers], bool]


def checked(claims: Sequence[Claim], numbers: Numbers, draws: Draws | None = None) -> dict[str, Stand]:
    """Each claim in this run, and over the draws: a draw's numbers take the place of the run's own. Of no
    draws at all none holds."""
    if draws is not None and not draws.count:
        return {claim.name: Stand(claim.words, 0.0, 0, False) for claim in claims}
    found = {}
    for claim in claims:
        here = bool(claim.holds(numbers))
        held = [bool(claim.holds({**numbers, **one})) for one in draws.each()] if draws else [here]
        found[claim.name] = Stand(claim.words, sum(held) / len(held), len(held) if draws else 0, here)
    return found
