"""What `[known]` says, looked up in the robot: numbers with their spread, and causes that are not there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import get_args

from scipy.optimize import brentq

from ..campaign.known import FactData
from ..campaign.problem import REFERENCE_TEMPERATURE, Problem
from ..files.faults import Fault, InputError
from ..files.tables import suggest
from ..robot.schema import EffectRecord
from . import catalogue
from .base import Effect
from .recorded import DataFault
from .records import PLACE, from_record, stated_effects

NEAR = 0.1  # of a number: no further from it is the slope taken that makes its spread the parameter's
CONTRADICTED = 3.0  # standard deviations (combined ones of two) from which a number is off another
EXACT = 1e-6  # of the usual size: the spread of what is exact


@dataclass(frozen=True)
class Given:
    """A number that is known: of an effect with one parameter, its value and standard deviation [the
    parameter's unit], and what was said."""

    effect: Effect
    value: float
    std: float
    fact: FactData

    @property
    def vague(self) -> bool:
        """Whether it leaves more open than is usual of any robot: then it says nothing that the data would
        have to be held to."""
        return self.std > self.effect.params[0].typical and abs(self.value) <= CONTRADICTED * self.std

    def is_for(self, effect: Effect) -> bool:
        """Whether an effect is this one: same cause, place and form."""
        return self.effect.key == effect.key and self.effect.variant == effect.variant


def given_facts(problem: Problem) -> tuple[Given, ...]:
    """The campaign's facts in this robot, as differences from its model. Raises `InputError` with all that
    cannot be."""
    found: list[Given] = []
    faults: list[Fault] = []
    for fact in problem.campaign.known.facts:
        try:
            given = _looked_up(fact, problem)
        except InputError as error:
            faults += error.faults
            continue
        if any(other.is_for(given.effect) for other in found):
            faults.append(Fault(_place(fact), "is said twice, differently", "say it once"))
        found.append(given)
    if faults:
        raise InputError(faults)
    return tuple(found)


def _looked_up(fact: FactData, problem: Problem) -> Given:
    place, whole = _place(fact), fact.parameter
    kind = catalogue().get(fact.cause)
    number = {} if kind is None or whole in kind.wholes else {whole: fact.value}
    where = {key: getattr(fact, key) for key in (*PLACE, "order")}
    item = EffectRecord(cause=fact.cause, variant=fact.variant, values=number, **where)
    effect = from_record(item, problem, place)[0]
    if len(effect.params) != 1:
        mend = "only a cause of one number can be given; say what is not there with exclude"
        raise InputError(Fault(place, f"{fact.cause} has {len(effect.params)} numbers here", mend))
    value, std = _number(effect, fact, fact.value, problem), 0.0
    if fact.std:
        step = min(0.5 * fact.std, NEAR * abs(fact.value)) or 0.5 * fact.std
        sides = [_number(effect, fact, fact.value + side * step, problem) for side in (-1, 1)]
        std = abs(sides[1] - sides[0]) / (2 * step) * fact.std
    (param,) = effect.params
    stated = [v for other, v in stated_effects(problem) if other == effect]
    if whole in effect.wholes:  # what the model's own effects add to it is there already
        value -= sum(float(v[0]) for v in stated)
    if not param.lower <= value <= param.upper:
        raise InputError(_too_far(effect, fact, value, problem))
    if abs(value) < EXACT * param.typical:  # the model's own number, as far as floats go
        value = 0.0
    return Given(effect, value, max(std, EXACT * param.typical), fact)


def _too_far(effect: Effect, fact: FactData, value: float, problem: Problem) -> Fault:
    """Of a number from which the model differs by more than the cause may be."""
    (param,) = effect.params
    what = f"{fact.parameter} {fact.value:g} is no {fact.cause}: {param.name} would be {value:g}"
    mend = f"between {param.lower:g} and {param.upper:g} {param.unit}".removesuffix(" 1")
    models = _models(effect, fact, problem)
    if models is not None:
        at = f" under [joints.{fact.joint}]" if fact.joint else ""
        what += f", since the model has {fact.parameter} {models:.6g}"
        mend = f"state it in the robot's TOML{at} if it is built so; {param.name} is {mend}"
    return Fault(_place(fact), what, mend)


def _models(effect: Effect, fact: FactData, problem: Problem) -> float | None:
    """The model's own number for a whole quantity; None where it is no whole, or the model has none near."""
    if fact.parameter not in effect.wholes or fact.value <= 0:
        return None

    def differs(value: float) -> float:
        return _number(effect, fact, value, problem)

    low, high = abs(fact.value) * 1e-3, abs(fact.value) * 1e3
    return float(brentq(differs, low, high)) if differs(low) * differs(high) < 0 else None


def _number(effect: Effect, fact: FactData, value: float, problem: Problem) -> float:
    """The effect's one parameter from a number as it was said."""
    if fact.parameter not in effect.wholes:
        return float(effect.given({fact.parameter: value})[0])
    warmth = 0.0 if fact.temp_degC is None else fact.temp_degC - REFERENCE_TEMPERATURE
    found = effect.of_whole(problem, fact.parameter, value, warmth)
    if found is None and effect.of_whole(problem, fact.parameter, abs(value) or 1.0, warmth) is not None:
        raise InputError(Fault(_place(fact), f"{value:g} is no {fact.parameter}", "give a positive number"))
    if found is None:
        mend = f"give {effect.params[0].name}, the difference from the model ({effect.params[0].unit})"
        raise InputError(Fault(_place(fact), f"the model has no {fact.parameter} to differ from", mend))
    return found


def _place(fact: FactData) -> str:
    where = [str(getattr(fact, key)) for key in PLACE if getattr(fact, key) is not None]
    return f"known: {fact.cause}({', '.join(where)}) {fact.parameter}" if where else f"known: {fact.cause}"


@dataclass(frozen=True)
class Exclusion:
    """A cause that is not there: everywhere, or at one place. text: as it was said."""

    text: str

    @property
    def cause(self) -> str:
        """The cause that is said not to be there."""
        return self.text.partition("(")[0].strip()

    def covers(self, effect: Effect) -> bool:
        said = self.text.replace(" ", "")
        return said in (effect.cause, effect.label.replace(" ", ""))


def may_be(effect: Effect, given: Iterable[Given], excluded: Iterable[Exclusion]) -> bool:
    """Whether an effect is neither given nor excluded."""
    said = any(fact.is_for(effect) for fact in given)
    return not said and not any(one.covers(effect) for one in excluded)


def exclusions(problem: Problem) -> tuple[Exclusion, ...]:
    """What the campaign's `[known] exclude` says. Raises `InputError` where it names nothing."""
    found = tuple(Exclusion(text) for text in problem.campaign.known.exclude)
    kinds = catalogue()
    faults = []
    for one in found:
        cause = one.cause
        if cause not in kinds:
            what, mend = f"no cause {cause!r}", suggest(cause, kinds) or f"known: {', '.join(kinds)}"
            if cause in get_args(DataFault):
                what = f"{cause!r} is a fault of the data, no cause: they are looked for in any case"
                mend = "mend it in the tables, or take it out"
            faults.append(Fault(f"known: exclude {one.text!r}", what, mend))
        elif one.text.strip() != cause and not _sits(one, kinds[cause].places(problem)):
            places = dict.fromkeys(effect.label for effect in kinds[cause].places(problem))
            what, mend = "cannot sit there", f"possible: {', '.join(places)}"
            if not places:
                why = kinds[cause].needs(problem) or "there is no place for it"
                what, mend = f"{cause} cannot be in this campaign anywhere: {why}", "leave it out"
            faults.append(Fault(f"known: exclude {one.text!r}", what, mend))
    if faults:
        raise InputError(faults)
    return found


def _sits(one: Exclusion, places: Sequence[Effect]) -> bool:
    return any(one.covers(effect) for effect in places)
