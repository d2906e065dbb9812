"""The catalogue: one file per cause. A new file with an `Effect` in it is a new cause."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Collection
from dataclasses import replace
from functools import cache

from ..campaign.problem import Problem
from ..robot.kinematics import Arm
from .base import UNKNOWN, Effect
from .kinds import SlotYield
from .place import NOWHERE, Where

Key = tuple[str, Where]  # cause and place
BESIDE = {
    "geometry": "Link lengths, offsets, twists, joint zeros: always fitted, the background, not a finding",
    UNKNOWN: "Something structured is left that no cause explains",
}
"""What a result names besides the catalogue."""


@cache
def catalogue() -> dict[str, type[Effect]]:
    """Cause id → class, in the order of the files' names; a class that is always a `variant` is a form of
    another's."""
    found: dict[str, type[Effect]] = {}
    for module in pkgutil.iter_modules(__path__):
        name = f"{__name__}.{module.name}"
        for value in vars(importlib.import_module(name)).values():
            kind = isinstance(value, type) and issubclass(value, Effect) and "cause" in vars(value)
            if kind and value.__module__ == name and value.cause != UNKNOWN and not value.variant:
                found[value.cause] = value
    return found


def called(cause: str) -> str:
    """A cause as people say it: `gear ratio`; the id's own words where the catalogue has no such cause."""
    kind = catalogue().get(cause)
    return kind.called if kind is not None and kind.called else cause.replace("_", " ")


def line(problem: Problem, joint: str, order: float) -> Effect:
    """The effect that carries a line of any `order` [cycles per joint turn, per 2π m] in a joint's error."""
    (kind,) = (kind for kind in catalogue().values() if kind.ordered)
    places = {place.where: place for place in kind.places(problem)}
    return replace(places[Where(joint=joint)], where=Where(joint=joint, order=order))


def separation(cause: str, rival: str) -> str | None:
    """The measurement that tells two causes apart on any robot, in words, whichever of the two says it; None:
    unknown."""
    return separation_beside((cause, NOWHERE), (rival, NOWHERE), (), None)


def separation_beside(one: Key, rival: Key, read: Collection[Key], problem: Problem | None) -> str | None:
    """`separation` of two causes at their places of a robot. read: causes and places of which another
    instrument has read the whole: that is not asked for again."""
    kinds = catalogue()
    pair = [key for key in (one, rival) if key[0] in kinds]
    said = [kinds[a[0]].separate.get(b[0]) for a, b in ((one, rival), (rival, one)) if a in pair]
    done = {kinds[key[0]].reading for key in pair if key in read}
    ways = next(filter(None, said), "").split(", or ")
    placed = sorted(pair, key=lambda key: key[1].joint is not None)
    words = {name: text for key in placed for name, text in kinds[key[0]].words(key[1], problem).items()}
    return ", or ".join(way for way in ways if way not in done).format_map(words) or None


def without_reflectors(advice: str) -> str:
    """Such words, "; " between them, without what asks for targets on the arm or its base: how much these
    bring can be worked out."""
    ways = [part.split(", or ") for part in advice.split("; ")]
    kept = [", or ".join(way for way in some if not way.startswith(("a target", "targets"))) for some in ways]
    return "; ".join(filter(None, kept))


def shown_on(effect: Effect, arm: Arm) -> str | None:
    """The link, or "base", on which a target near its joint tells what sits there from what sits further out
    or further in; None: the effect has no such place."""
    where = effect.where
    if where.joint is not None:
        return arm.links[arm.slot_of_joint(where.joint)]
    if where.link is not None:
        return where.link
    return "base" if isinstance(effect, SlotYield) and effect.slot(arm) == 0 else None


def rivals(cause: str) -> tuple[str, ...]:
    """Causes that are easily taken for this one, its own first, then those that say so themselves."""
    kinds = catalogue()
    others = [other for other, kind in kinds.items() if cause in kind.separate]
    return tuple(dict.fromkeys([*kinds[cause].separate, *others]))
