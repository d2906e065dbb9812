"""Effects as text and as records: `--effect` of the command line, `[[effects]]` of a model.toml."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..campaign.problem import Problem
from ..files.faults import Fault, InputError
from ..files.toml import SHOWN
from ..robot.kinematics import Array
from ..robot.schema import EffectRecord, stated_load
from . import catalogue
from .base import UNKNOWN, Effect
from .place import Where
from .unnamed import kind_of

PLACE = ("joint", "other", "link", "payload")


def record(effect: Effect, values: Array) -> EffectRecord:
    """The effect and its fitted values, as model.toml keeps them."""
    numbers = {p.name: float(v) for p, v in zip(effect.params, values, strict=True)}
    numbers |= {name: float(getattr(effect, name)) for name in effect.settings}
    return EffectRecord(cause=effect.cause, variant=effect.variant, values=numbers, **effect.where.keys())


def effect_text(effect: Effect, values: Array) -> str:
    """The effect and its values as one line, which `parse_effect` reads."""
    item = record(effect, values)
    pairs = item.model_dump(include={*PLACE, "order", "variant"}, exclude_defaults=True) | item.values
    return f"{item.cause}:" + ",".join(f"{key}={value}" for key, value in pairs.items())


def parse_effect(text: str, problem: Problem) -> tuple[Effect, Array]:
    """An effect and its values from `cause:joint=...,amplitude=...`, names as in `result.json`.

    Without any number the effect has its typical size. Raises `InputError`.
    """
    cause, _, rest = text.partition(":")
    strings: dict[str, Any] = {}
    numbers: dict[str, float] = {}
    for pair in filter(None, (part.strip() for part in rest.split(","))):
        key, equals, value = (part.strip() for part in pair.partition("="))
        if not equals:
            raise InputError(Fault(text, f"{pair!r} is no key=value", "like joint=joint_2"))
        if key in (*PLACE, "variant"):
            strings[key] = value
            continue
        try:
            numbers[key] = float(value)
        except ValueError:
            numbers[key] = math.nan
        if not math.isfinite(numbers[key]):
            raise InputError(Fault(text, f"{key} is {value[:SHOWN]!r}, not a number"))
    order = numbers.pop("order", None)
    if order is not None and order <= 0:
        raise InputError(Fault(text, f"order is {order:g}", "cycles per joint turn, above zero"))
    return from_record(
        EffectRecord(cause=cause.strip(), order=order, values=numbers, **strings), problem, text
    )


def check_possible(text: str, effect: Effect, values: Array) -> None:
    """Raises InputError for values (p,) that physics does not allow. text: where they are said."""
    faults = [
        Fault(text, f"{p.name} = {value:g} cannot be", f"between {p.lower:g} and {p.upper:g} {p.unit}")
        for p, value in zip(effect.params, values, strict=True)
        if not p.lower <= value <= p.upper
    ]
    if faults:
        raise InputError(faults)


def from_record(item: EffectRecord, problem: Problem, text: str = "") -> tuple[Effect, Array]:
    """The effect of a record, and its values (p,). Raises `InputError` when it cannot be."""
    text = text or f"effect {item.cause}"
    kinds = catalogue()
    if item.cause not in kinds and (item.cause != UNKNOWN or kind_of(item.variant) is None):
        raise InputError(Fault(text, f"no cause {item.cause!r}", f"known: {', '.join(kinds)}"))
    _check_names(item, problem, text)
    free = kind_of(item.variant) if item.cause == UNKNOWN else None
    effect = (
        free(Where(item.joint, item.other, item.link, order=item.order), item.variant)
        if free
        else _place(kinds[item.cause], item, problem, text)
    )
    settings: dict[str, Any] = {name: item.values[name] for name in effect.settings if name in item.values}
    if settings.get("torque", 1.0) <= 0:
        raise InputError(Fault(text, f"torque = {settings['torque']:g} cannot be", "above zero"))
    effect = replace(effect, **settings)
    known = (*effect.names, *effect.settings)
    unknown = [name for name in item.values if name not in known]
    if unknown:
        said = {p.name: f"{p.name} ({p.meaning})" for p in effect.params}
        mend = f"known: {', '.join(said.get(name, name) for name in known)}"
        raise InputError([Fault(text, f"no parameter {name!r}", mend) for name in unknown])
    if any(name in effect.names for name in item.values):
        return effect, effect.given(item.values)
    return effect, np.array([p.typical for p in effect.params])


def stated_effects(problem: Problem) -> list[tuple[Effect, Array]]:
    """The effects that the robot's own TOML states (a model.toml), as far as they touch this campaign.

    A payload that the campaign does not carry is left out, and so is what was found of another tool than the
    campaign's; without temperature the arm is at 20 °C.
    """
    return [
        from_record(item, problem, f"{problem.robot.path}: effects")
        for item in problem.robot.effects
        if is_mounted(item, problem)
    ]


def is_mounted(item: EffectRecord, problem: Problem) -> bool:
    """Whether an effect of the robot's TOML is of no load, or of one that the campaign has as well: of the
    same name alone, where the TOML does not state it."""
    if item.payload is None:
        return True
    robot, campaign = problem.robot, problem.campaign
    stated = robot.payloads.get(item.payload)
    if stated is None and item.payload in campaign.payload_names[1:]:
        return True
    return campaign.has_load(item.payload, *stated_load(stated or robot.tool))


def _check_names(item: EffectRecord, problem: Problem, text: str) -> None:
    arm = problem.arm
    known = {
        "joint": arm.names,
        "other": arm.names,
        "link": arm.links,
        "payload": (*problem.campaign.payload_names[1:], problem.campaign.tool_name),
    }
    faults = [
        Fault(text, f"no {key} {getattr(item, key)!r}", f"known: {', '.join(known[key]) or 'none'}")
        for key in PLACE
        if getattr(item, key) is not None and getattr(item, key) not in known[key]
    ]
    if faults:
        raise InputError(faults)


def _place(kind: type[Effect], item: EffectRecord, problem: Problem, text: str) -> Effect:
    """The effect at the record's place and in its variant."""
    places = kind.places(problem)
    where = Where(item.joint, item.other, item.link, item.payload, item.order)
    forms = [place for place in places if _matches(place, where, item.variant)]
    if forms:  # of several, the one whose numbers were said
        place = next(
            (form for form in forms if item.values.keys() <= {*form.names, *form.settings}), forms[0]
        )
        return replace(place, variant=item.variant or place.variant)
    for place in places:  # any order
        free = place.ordered and place.where.order is None
        if free and item.order and not item.variant and replace(place.where, order=item.order) == where:
            return replace(place, where=where)
    why = None if places else kind.needs(problem)
    what = "cannot sit there" if str(where) or item.variant else "does not say where it sits"
    raise InputError(Fault(text, why or what, "" if why else _possible(places)))


def _matches(place: Effect, where: Where, variant: str) -> bool:
    if variant not in ("", place.variant, place.variant.split(" ")[0]):
        return False
    if where.order is None:
        # the order of a known ratio goes without saying when the variant names it
        named = bool(variant) if place.ordered else True
        return place.where.any_order == where and named
    same = place.where.order is not None and bool(np.isclose(place.where.order, where.order, rtol=1e-12))
    return same and place.where.any_order == where.any_order


def _possible(places: Sequence[Effect]) -> str:
    said: dict[str, None] = {}
    for place in places:
        keys = place.where.keys() | ({"variant": place.variant} if place.variant else {})
        if place.ordered:
            keys = {"joint": place.where.joint, "order": "(cycles per joint turn)"}
        said[",".join(f"{key}={value}" for key, value in keys.items())] = None
    listed = [text for text in said if text]
    return f"possible: {'; '.join(listed[:12])}" + (" ..." if len(listed) > 12 else "") if listed else ""
