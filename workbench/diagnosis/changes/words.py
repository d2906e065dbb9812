"""A comparison in one line."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...effects.base import UNKNOWN
from ...effects.place import Parameter
from ..telling.headline import listed, words_of
from .candidates import PLACED
from .found import BACK, CREEP, LEVELS, PHASE, POSSIBLE, Change, Rival, bounds

MOST_SAID = 3
MOST_WAYS = 4  # that something may be, in one line
WORTH_SAYING = 0.05  # share of what a change may be instead, of all that it may be
CLEAR = 3.0  # standard deviations from which a number did change
SAID = {"rad": (1e3, "mrad"), "m": (1e3, "mm"), "rad/(N·m)": (1e9, "nrad/(N·m)")}


def said(*numbers: Parameter) -> str:
    """One number with one sigma, in the unit of the shop floor; or of two, from what to what."""
    p = numbers[0]
    factor, unit = (180 / math.pi, "°") if p.name == PHASE else SAID.get(p.unit, (1.0, p.unit))
    if p.unit == "1":
        factor, unit = 100.0, "% of the model's" if p.name == "relative" else "%"
    text = " to ".join(with_std(factor * p.value, factor * p.std) for p in numbers)
    return f"{text} {unit}".strip()


def with_std(value: float, std: float) -> str:
    """Both with as many decimals as the uncertainty has worth: two figures where it begins with 1, else
    one."""
    if not std > 0:
        return f"{value:.3g}"
    digits = 1 if f"{std:.1e}"[0] in "123" else 0
    decimals = max(0, digits - int(f"{std:e}".split("e")[1]))
    if decimals > 6:
        return f"{value:.3g} ± {std:.2g}"
    return f"{value:.{decimals}f} ± {std:.{decimals}f}"


def tells(size_mm: float, std_mm: float, nominal_mm: float) -> bool:
    """Whether a length with its one sigma says where something is: to less than what the nominal robot is
    off, or that it did move."""
    return std_mm < nominal_mm or size_mm > CLEAR * std_mm


def moved_by(change: Change) -> str:
    """joint_4 zero moved by 0.31 ± 0.02 mrad; of one that is back, crept or moved again, where and since
    when."""
    largest = _clearest(change.parameters)
    one = len(change.parameters) == 1 and not change.before
    at = f"{change.moves_mm:.2f} mm RMS at the targets"
    what = name_of(change)
    stepped = "moved" if change.cause == PLACED and (one or change.course == LEVELS) else "changed"
    if change.cause == UNKNOWN:
        return f"{what} changed by {at}"
    by = said(largest) if one else f"{at} ({_from_to(change) or f'{largest.name} by {said(largest)}'})"
    if change.course == BACK:
        return f"{what} was off by {by} in {listed([label for label, _ in change.levels])}"
    if change.course == CREEP:
        return f"{what} crept evenly since {change.since}, by {by} up to {change.levels[-1][0]}"
    if change.course == LEVELS:
        each = [f"{said(_clearest(numbers))} in {label}" for label, numbers in change.levels]
        of = "" if one else f"{at}: {largest.name} "
        return f"{what} {stepped} more than once, against the first by {of}{listed(each)}"
    return f"{what} {'is off' if change.side == 'load' else stepped} by {by}"


def _from_to(change: Change) -> str:
    """From what to what the numbers changed that clearly did, where it is known."""
    every = list(zip(change.parameters, change.before, change.after, strict=True)) if change.before else []
    clear = [one for one in every if abs(one[0].value) > CLEAR * one[0].std] or every[:1]
    return ", ".join(f"{by.name} from {said(before, after)}" for by, before, after in clear)


def _clearest(numbers: Sequence[Parameter]) -> Parameter:
    """The number that is most of its uncertainties; where something came alone, its phase says not how large
    it is."""
    sizes = [p for p in numbers if p.name != PHASE] or numbers
    return max(sizes, key=lambda p: abs(p.value) / max(p.std, 1e-300))


def headline(
    changes: Sequence[Change],
    within_mm: float,
    apart: Sequence[str],
    robot_changed: bool,
    hidden: Sequence[str] = (),
    nominal_mm: float = math.inf,
    last: str = "",
) -> str:
    """What changed, what did not, and what is not the robot. within_mm: bound of all else, said where it is
    it `bounds` them, beside what the nominal robot is off (nominal_mm); else what the `last`
    campaign could not have shown. hidden: joints a change of whose zero would look like a move of the
    instrument or the targets."""
    told = [c for c in changes if c.placed or c.status != POSSIBLE]
    robot = [c for c in told if c.side == "robot"]
    sure = [moved_by(c) for c in changes if c.status == "named"]
    open_ = [_either(c) for c in told if c.status != "named"]
    none = not any(map(_may_be_robot, told)) and not robot_changed
    if bounds(within_mm, nominal_mm, robot):
        what = "the robot is" if none else "everything else"
        rest = f"{what} unchanged within {max(within_mm, 0.001):.2g} mm"
        but = "but for"
    else:
        size = hidden_size(within_mm, nominal_mm)
        seen = "no change of the robot is seen; changes" if none else "other changes"
        rest, but = f"{seen} {size} could not have been seen{f' in {last}' if last else ''}", "nor"
    if hidden:
        zeros = "zero" if len(hidden) == 1 else "zeros"
        like = "to these data a move of the instrument or the targets"
        rest += f" ({but} the {zeros} of {listed(hidden)}: {like})"
    parts = [*sure[:MOST_SAID], *(["and more"] if len(sure) > MOST_SAID else []), *open_[:MOST_SAID]]
    nowhere = [_either(c) for c in changes if c.status == POSSIBLE and not c.placed]
    text = "; ".join([*parts, rest, *nowhere[:MOST_SAID], *apart])
    return f"{text}." if sure else f"{text[0].upper()}{text[1:]}."  # a name stays as it is written


def _may_be_robot(change: Change) -> bool:
    """Whether a change that is told is of the robot, or one that is told in its place."""
    return "robot" in (change.side, *(r.side for r in _likely(change) if r.change))


def _likely(change: Change) -> list[Rival]:
    """What it may be instead."""
    total = sum(way.probability for way in change.ways)
    return [r for r in change.rivals if r.probability >= WORTH_SAYING * total]


def hidden_size(within_mm: float, nominal_mm: float) -> str:
    """How large what could not have been seen may be."""
    if within_mm < nominal_mm:
        return f"up to {within_mm:.2g} mm at the targets"
    return f"as large as the nominal robot's error ({nominal_mm:.2g} mm)"


def _either(change: Change) -> str:
    if change.status == POSSIBLE:
        return _perhaps(change)
    names = [f"{name_of(way)}{'' if way.change else ' (in all campaigns)'}" for way in change.ways]
    some = " or ".join([*names[:MOST_WAYS], *(["something less likely"] if names[MOST_WAYS:] else [])])
    return f"something {_course(change)}, not decided: {some}"


def _course(change: Change) -> str:
    """That it changed, when, and by how much."""
    by = f"{change.moves_mm:.2f} mm RMS at the targets"
    if change.course == BACK:
        return f"was off by {by} in {listed([label for label, _ in change.levels])}"
    if change.course == CREEP:
        return f"crept evenly since {change.since}, by {by}"
    return f"changed {'more than once, ' if change.course == LEVELS else ''}by {by}"


def name_of(one: Change | Rival) -> str:
    """What changed, as people say it: a cause by its name and place, a number of the geometry by its own."""
    return words_of(one.cause, one.where) if one.label.startswith(one.cause) else one.label


def _perhaps(change: Change) -> str:
    """A change that may be none, with what else it may be."""
    if not change.placed:
        return f"something of {change.moves_mm:.2f} mm RMS at the targets cannot be placed"
    likely = _likely(change)[: MOST_WAYS - 1]
    others = [f"{name_of(r)} {'did' if r.change else 'is in all campaigns'}" for r in likely]
    others += ["something less likely"] if len(likely) < len(change.rivals) else []
    ways = [f"{name_of(change)} {_course(change)}", *others]
    return f"not decided: {', or '.join(ways)}" if others else f"perhaps {ways[0]}"
