"""Causes as `--tell` names them, where they may sit, and the factors of the experiment that show them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from ...campaign.problem import Problem
from ...diagnosis.candidates import untold
from ...effects import catalogue
from ...effects.base import UNKNOWN, Effect
from ...effects.records import PLACE, parse_effect
from ...files.faults import Fault, InputError
from ...files.toml import SHOWN
from .candidates import Factors

KEYS = (*PLACE, "order", "variant")
CHANCE = "probability"  # what a diagnosis gives a cause
EXAMPLE = "like gear_ratio:joint=joint_2,hose_torque:joint=joint_4 or gear_ratio,hose_torque"


@dataclass(frozen=True)
class NamedCause:
    """A cause with the place and form that were said; text: in the spelling of `--effect`."""

    text: str
    kind: type[Effect]
    asked: tuple[tuple[str, str], ...]

    def sites(self, problem: Problem) -> list[Effect]:
        """Those of its sites in this campaign that are as asked."""
        return [effect for effect in self.kind.sites(problem) if self._fits(effect)]

    def _fits(self, effect: Effect) -> bool:
        if effect.rare and effect.free and ("variant", effect.variant) not in self.asked:
            return False  # by no law: that is like anything, and asked for by its name alone
        for key, value in self.asked:
            if key == "variant" and value not in (effect.variant, effect.variant.split(" ")[0]):
                return False
            if key != "variant" and value != str(getattr(effect.where, key)):
                return False
        return True

    def effects(self, problem: Problem) -> list[Effect]:
        """What the cause may be: at every place and in every form left open. Raises InputError."""
        why = untold(self.kind, problem)
        if why is not None:
            raise InputError(Fault(f"--tell {self.text}", why))
        # an order of its own, or a place that is not there (then with the fault of it)
        return self.sites(problem) or [parse_effect(self.text, problem)[0]]


def split_ties(text: str) -> list[str]:
    """The ties of `--tell`, which semicolons part; one, empty, where nothing is said.

    >>> split_ties("hose_torque:joint=joint_4,gear_ratio; backlash:joint=joint_1,lost_motion")
    ['hose_torque:joint=joint_4,gear_ratio', 'backlash:joint=joint_1,lost_motion']
    """
    return [part.strip() for part in text.split(";") if part.strip()] or [""]


def split_causes(text: str) -> list[str]:
    """The causes of `--tell`: a part without a colon that is key=value belongs to the cause before it."""
    found: list[str] = []
    for part in (part.strip() for part in text.split(",")):
        if found and "=" in part and ":" not in part:
            found[-1] += f"{',' if ':' in found[-1] else ':'}{part}"
        elif part:
            found.append(part)
    return found


def has_size(cause: str) -> bool:
    """Whether a cause of `--tell` has numbers, as `--effect` takes them."""
    return any(equals and key not in (*KEYS, CHANCE) for key, equals, _ in pairs_of(cause))


def chance_of(cause: str) -> tuple[str, float | None]:
    """A cause of `--tell` without its probability, and that, if it is said. Raises InputError."""
    kept, said = [], None
    for key, equals, value in pairs_of(cause):
        if key != CHANCE:
            kept.append(f"{key}{equals}{value}")
            continue
        try:
            said = float(value)
        except ValueError:
            said = -1.0
        if not 0 <= said <= 1:
            raise InputError(
                Fault(f"--tell {cause}", f"{CHANCE} is {value[:SHOWN]!r}", "a number from 0 to 1")
            )
    return ":".join(filter(None, (cause.partition(":")[0], ",".join(kept)))), said


def named_causes(text: str) -> tuple[NamedCause, ...]:
    """The causes of `--tell`, two or more. Raises InputError."""
    found = split_causes(text)
    faults = [fault for item in found for fault in _faults(item)]
    if not faults and len(found) < 2:
        faults = [Fault("--tell", f"{text!r} names {'one' if found else 'no'} cause, not two", EXAMPLE)]
    if faults:
        raise InputError(faults)
    return tuple(_named(item) for item in found)


def _faults(item: str) -> list[Fault]:
    cause = item.partition(":")[0]
    if cause not in catalogue():
        return [Fault("--tell", f"no cause {cause!r}", f"known: {', '.join(catalogue())}")]
    how = f"keys are {', '.join(KEYS)}, as in joint=joint_2"
    return [
        Fault(f"--tell {item}", f"{key!r} is no place or form", how)
        for key, equals, _ in pairs_of(item)
        if key not in KEYS or not equals
    ]


def _named(item: str) -> NamedCause:
    asked = tuple((key, value) for key, _, value in pairs_of(item))
    return NamedCause(item, catalogue()[item.partition(":")[0]], asked)


def pairs_of(item: str) -> list[tuple[str, str, str]]:
    """Key, "=" and value of each of a cause's places, forms and sizes."""
    return [part.partition("=") for part in item.partition(":")[2].split(",") if part]


def factors(causes: Sequence[NamedCause], trial: Problem) -> Factors:
    """What besides pose and payload a plan for these causes must vary; trial: varies everything."""
    return varied(effect for cause in causes for effect in cause.sites(trial))


def varied(effects: Iterable[Effect]) -> Factors:
    """What besides pose and payload has to vary for these effects to show; for one without a name nobody
    waits, or warms an arm."""
    depends = frozenset[str]().union(*(effect.uses for effect in effects if effect.cause != UNKNOWN))
    return Factors("side" in depends, "temperature" in depends, "time" in depends)


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
