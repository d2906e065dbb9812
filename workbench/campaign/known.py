"""`[known]`: what is known besides the measurement, as the TOML and `--known` say it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import Field, FiniteFloat, ValidationError

from ..files.faults import Fault, InputError
from ..files.measure import AboveZero
from ..files.section import Section

Name = Annotated[str, Field(min_length=1)]
EXAMPLE = 'like link_mass:link=link_2,mass_kg=311,std=2 or "no backlash(joint_5)"'
_TEXTS = ("joint", "other", "link", "payload", "variant", "note")
_NUMBERS = ("order", "std", "temp_degC")


class FactData(Section):
    """`[[known.facts]]`: one number of one cause, measured by other means.

    parameter: as `workbench causes` lists it, the difference from the robot's model; or the whole quantity:
    `mass_kg` of a link, payload or tool, `stiffness` (N·m/rad, N/m) and `ratio` of a joint, of the
    compensator `precharge_bar` (absolute), `gauge_bar` (over the atmosphere), both at its `reference`, `rate`
    (N/m), or of a spring `free_length` (m, with variant = "preload").
    """

    cause: Name
    """as `workbench causes` lists it"""
    joint: str | None = None
    """where it sits"""
    other: str | None = None
    """the joint that it moves with"""
    link: str | None = None
    """where it sits"""
    payload: str | None = None
    """which load; `tool`: what is always mounted"""
    order: FiniteFloat | None = None
    """cycles per joint turn; of a sliding joint 2π over its period in m"""
    variant: str = ""
    """its form"""
    parameter: Name
    """which number: of the cause, or `mass_kg`, `stiffness`, `ratio`, `precharge_bar`, `gauge_bar`, `rate`,
    `free_length`"""
    value: FiniteFloat
    """the number"""
    std: Annotated[FiniteFloat, Field(ge=0)]
    """its standard deviation; 0: exact"""
    temp_degC: FiniteFloat | None = None
    """at which a pressure was read; absent = 20 °C"""
    note: str = ""
    """how it is known, for pages"""

    @property
    def said(self) -> str:
        """As it was said, for people."""
        spread = f" ± {self.std:g}" if self.std else " exactly"
        at = "" if self.temp_degC is None else f" at {self.temp_degC:g} °C"
        return f"{self.parameter} {self.value:g}{spread}{at}"


class KnownData(Section):
    """`[known]`: what is known of the instrument and of the robot, besides what was measured here."""

    scale: AboveZero = 1.0
    """true length by the length that the instrument shows"""
    exclude: tuple[Name, ...] = ()
    """causes that are not there: `hose_torque`, or at one place `backlash(joint_5)`"""
    facts: tuple[FactData, ...] = ()
    """numbers measured by other means"""

    def and_more(self, other: KnownData) -> KnownData:
        """Both together, nothing twice; the scale is this one's."""
        exclude = tuple(dict.fromkeys((*self.exclude, *other.exclude)))
        facts = tuple(dict.fromkeys((*self.facts, *other.facts)))
        return self.model_copy(update={"exclude": exclude, "facts": facts})


def and_told(known: KnownData, texts: Sequence[str]) -> KnownData:
    """What is known with what `--known` says besides. Raises InputError."""
    faults: list[Fault] = []
    for text in texts:
        try:
            known = known.and_more(parse_known(text))
        except InputError as error:
            faults += error.faults
    if faults:
        raise InputError(faults)
    return known


def _number(text: str) -> float | str:
    """What a text says as a number; itself where it is none: that is told as a fault of its key."""
    try:
        return float(text)
    except ValueError:
        return text


def parse_known(text: str) -> KnownData:
    """`no CAUSE`, `no CAUSE(PLACE)`, or `CAUSE:place=...,PARAMETER=NUMBER,std=NUMBER`. Raises InputError."""
    excluded = re.fullmatch(r"\s*no\s+(.+?)\s*", text)
    if excluded:
        return KnownData(exclude=(excluded[1],))
    cause, _, rest = text.partition(":")
    place, said, numbers = f"--known {text}", dict[str, Any](), dict[str, str]()
    for pair in filter(None, (part.strip() for part in rest.split(","))):
        key, equals, value = (part.strip() for part in pair.partition("="))
        if not equals:
            raise InputError(Fault(place, f"{pair!r} is no key=value", EXAMPLE))
        if key in (*_TEXTS, *_NUMBERS):
            said[key] = _number(value) if key in _NUMBERS else value
        else:
            numbers[key] = value
    if len(numbers) != 1:
        raise InputError(Fault(place, f"says {len(numbers)} numbers, not one", EXAMPLE))
    ((parameter, value),) = numbers.items()
    try:
        fact = FactData(cause=cause.strip(), parameter=parameter, value=_number(value), **said)  # type: ignore[arg-type]
    except ValidationError as error:
        where = [f"{place}: {'.'.join(map(str, item['loc']))}" for item in error.errors()]
        what = [str(item["msg"]) for item in error.errors()]
        raise InputError([Fault(w, m, EXAMPLE) for w, m in zip(where, what, strict=True)]) from None
    return KnownData(facts=(fact,))
