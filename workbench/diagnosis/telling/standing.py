"""How a cause stands among all that compete: how sure it is, its rivals, and why it has no name for sure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...effects.base import UNKNOWN, Effect
from ..found import Rival
from ..priors import PRIORS
from ..search.competition import Selection
from ..weighing.chosen import Shares
from ..weighing.components import Component, bare
from .headline import listed


@dataclass(frozen=True)
class Standing:
    """A cause at its place among all that compete. rivals: those that cover the rest, likeliest first, and
    those that only their prior odds keep from it; nameless: what those without a name are, in words; faint:
    the likeliest of the others, without which it would be named were there no rivals; by_data: its
    probability where no other cause is less likely before the data than it: what the data alone say."""

    probability: float
    rivals: tuple[Rival, ...]
    nameless: tuple[str, ...]
    faint: tuple[Rival, ...]
    by_data: float


def standing(selection: Selection, effect: Effect) -> Standing:
    """How a cause stands at its place, where it is likeliest."""
    best: tuple[float, Shares, int] | None = None
    for member, share in zip(selection.members, selection.shares, strict=True):
        component = selection.components[member.component]
        same = bare(component.key) == effect.key
        if same and (best is None or share[member.component] > best[0]):
            best = share[member.component], share, member.component
    assert best is not None
    probability, share, index = best
    raised = {k: p * _handicap(selection.components, index, k) for k, p in share.items()}
    total = sum(raised.values())
    covered, rivals, faint, nameless = probability, list[Rival](), list[Rival](), dict[str, None]()
    others = sorted(((p, k) for k, p in share.items() if k is not None and k != index), reverse=True)
    for p, k in others:
        component = selection.components[k]
        rival = Rival(*component.key, p, component.called)
        close = raised[k] >= (1 - PRIORS.by_data) * total
        worth_a_word = close or (covered < PRIORS.listed and p >= PRIORS.faintest_rival)
        if (rival.cause, rival.where) != effect.key:
            (rivals if worth_a_word else faint).append(rival)
            if worth_a_word and rival.cause == UNKNOWN and component.effect is not None:
                nameless[component.effect.label] = None
        covered += p if worth_a_word else 0.0
    late = _not_yet_named(probability, faint)
    return Standing(probability, tuple(rivals), tuple(nameless), late, raised[index] / total)


def _not_yet_named(probability: float, faint: Sequence[Rival]) -> tuple[Rival, ...]:
    """The first of these rivals, likeliest first, until the others leave half of what a name leaves."""
    left = sum(rival.probability for rival in faint)
    kept = list[Rival]()
    for rival in faint:
        if left <= (1 - PRIORS.named) / 2 * probability:
            break
        kept.append(rival)
        left -= rival.probability
    return tuple(kept)


def _handicap(components: Sequence[Component], own: int, other: int | None) -> float:
    """By how much a cause was less likely than another before the data. A line's odds are also those of its
    order, and functions without a name stand for what nobody knows: these stay as they are."""
    if other is None or components[other].nameless or components[other].key[1].order is not None:
        return 1.0
    return float(np.exp(max(components[own].log_odds - components[other].log_odds, 0.0)))


def why_open(found: Standing) -> list[str]:
    """Why a cause has no name for sure, as far as its rivals do not say that."""
    if found.nameless:
        said = listed(found.nameless)
        fits = "fits as well, which has" if len(found.nameless) == 1 else "fit as well, which have"
        return [f"{said[0].upper()}{said[1:]} {fits} no name."]
    if found.rivals:
        return []
    has = f"it has {100 * found.probability:.0f} %"
    if found.probability >= PRIORS.named:
        has = "without what speaks for it before the data it has less"
    return [f"No other that was tried fits as well, but a name needs {100 * PRIORS.named:.0f} %: {has}."]
