"""Causes as `--tell` names them, where they may sit, and what they depend on besides pose and payload."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...campaign.problem import Problem
from ...effects import catalogue
from ...effects.base import Effect
from ...effects.records import PLACE, parse_effect
from ...files.faults import Fault, InputError
from .candidates import Factors

KEYS = (*PLACE, "order", "variant")
EXAMPLE = "like gear_ratio:joint=joint_2,hose_torque:joint=joint_4 or gear_ratio,hose_torque"


def split_causes(text: str) -> tuple[str, str]:
    """The two causes of `--tell`, each in the spelling of `--effect`: a part without a colon that is
    key=value belongs to the cause before it."""
    found: list[str] = []
    for part in (part.strip() for part in text.split(",")):
        if found and "=" in part and ":" not in part:
            found[-1] += f"{',' if ':' in found[-1] else ':'}{part}"
        elif part:
            found.append(part)
    if len(found) != 2:
        raise InputError(Fault("--tell", f"{text!r} names {len(found)} causes, not two", EXAMPLE))
    kinds = catalogue()
    faults = [
        Fault("--tell", f"no cause {name!r}", f"known: {', '.join(kinds)}")
        for name in (item.partition(":")[0] for item in found)
        if name not in kinds
    ]
    if faults:
        raise InputError(faults)
    return found[0], found[1]


def factors(named: Sequence[str]) -> Factors:
    """What besides pose and payload these causes depend on."""
    causes = {item.partition(":")[0] for item in named}
    warm = "thermal_growth" in causes or any("variant=temperature" in item for item in named)
    return Factors("backlash" in causes, warm, "drift" in causes)


def cause_places(item: str, whole: Problem) -> list[Effect]:
    """The effects that a cause may be: at every place and in every form that its keys leave open."""
    cause, _, rest = item.partition(":")
    kind = catalogue()[cause]
    pairs = [part.partition("=") for part in rest.split(",") if part]
    faults = [
        Fault(
            f"--tell {item}",
            f"{key!r} is no place or form",
            f"keys are {', '.join(KEYS)}, as in joint=joint_2",
        )
        for key, equals, _ in pairs
        if key not in KEYS or not equals
    ]
    why = kind.needs(whole)
    if why is not None:
        faults.append(Fault(f"--tell {item}", why))
    if faults:
        raise InputError(faults)
    asked = {key: value for key, _, value in pairs}
    fits = [effect for effect in kind.sites(whole) if _fits(effect, asked)]
    # an order of its own, or a place that is not there (then with the fault of it)
    return fits or [parse_effect(item, whole)[0]]


def _fits(effect: Effect, asked: dict[str, str]) -> bool:
    for key, value in asked.items():
        if key == "variant" and value not in (effect.variant, effect.variant.split(" ")[0]):
            return False
        if key != "variant" and value != str(getattr(effect.where, key)):
            return False
    return True


def keys(effect: Effect) -> dict[str, Any]:
    """The cause and its place, as `result.json` says them, and its form."""
    variant = {"variant": effect.variant} if effect.variant else {}
    return {"cause": effect.cause, **effect.where.keys(), **variant}


def label(effect: Effect) -> str:
    """The cause with its place and form, for people."""
    parts = [str(effect.where)] if str(effect.where) else []
    if effect.where.order:
        parts.append(f"{effect.where.order:g} cycles")
    elif effect.variant:
        parts.append(f"variant {effect.variant}")
    return f"{effect.cause}({', '.join(parts)})" if parts else effect.cause
