"""Which columns of somebody else's table are x, y and z of a target, and which the turn of a 6-D one."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from .file import ANGLES, QUATERNION
from .guess_text import LENGTHS, Array, Text, angle_unit, counts, is_numbers, odd_cell, plain, unit_of

Triple = tuple[int, int, int]

AS_MUCH = 0.5  # of what the columns vary by that vary most: those of measured beside nominal places do
FEWEST = 8  # rows that say whether two places are on one arm
STILL = 1e-3  # of its distance: less moves what stands on the base
SAME, RIGID = 0.01, 0.05  # of what places vary by: two targets are farther apart, and as far in all poses
TURN = 0.01  # that the length of a quaternion is off 1
CALLED = (
    ("rx", "ry", "rz"), ("rotx", "roty", "rotz"), ("roll", "pitch", "yaw"), ("c", "b", "a"),
)  # fmt: skip
"""what angles about x, y and z are called; KUKA's A is about z"""
OTHER = re.compile(
    r"[dusrnv]|\w*(nom|soll|theo|ref|cad|cmd|dev|abw|diff|delta|err|unc|unsich|sig|std|rms|tol|rot|ori|ang"
    r"|quat|norm|vel)\w*"
)  # what x, y, z are called that are no measured place


def places_of(text: Text) -> tuple[dict[str, Triple], str]:
    """Target → columns of x, y, z; and why there are none, where it is not that the table has none."""
    numbers = [i for i, column in enumerate(text.columns) if is_numbers(column)]
    if not text.header:
        side_by_side = _side_by_side(text, numbers)
        return ({"": side_by_side[-1]} if side_by_side else {}), ""
    whole = {
        name: place
        for name, place in _triples(text, numbers).items()
        if unit_of(text, place[0]) in (None, *LENGTHS) and _turn_with(text, place) is None
    }
    if "" in whole:
        return {"": whole[""]}, ""
    if not _on_one_arm(text, whole):
        measured = {name: place for name, place in whole.items() if not OTHER.fullmatch(name)}
        if not measured or not _on_one_arm(text, measured):
            names = " and ".join(_called(text, place) for place in whole.values())
            return {}, f"{names} are not targets on one arm: say which is what was measured"
        whole = measured
    if not whole:
        named = _triples(text, range(len(text.columns))).values()
        return {}, next((odd for place in named if (odd := odd_cell(text, place))), "")
    if len(whole) == 1:
        return {"": next(iter(whole.values()))}, ""
    return {f"T{name}" if name.isdigit() else name.upper(): place for name, place in whole.items()}, ""


def _triples(text: Text, numbers: Sequence[int]) -> dict[str, Triple]:
    """What is named x, y and z, by the rest of the name; numbered where that comes again."""
    axes: dict[str, dict[str, list[int]]] = {}
    for i in numbers:
        if match := re.fullmatch(r"([xyz])(\w*)|(\w*?)([xyz])", plain(text.header[i])):
            axis, name = (match[1], match[2]) if match[1] else (match[4], match[3])
            axes.setdefault(name, {}).setdefault(axis, []).append(i)
    found = dict[str, Triple]()
    for name, columns in axes.items():
        if len(columns) == 3:
            again = list(zip(columns["x"], columns["y"], columns["z"], strict=False))
            found |= {name if len(again) == 1 else f"{name}{k}": one for k, one in enumerate(again, 1)}
    return found


def _called(text: Text, place: Triple) -> str:
    return ", ".join(str(text.header[i] if isinstance(text.name(i), str) else text.name(i)) for i in place)


def _on_one_arm(text: Text, places: Mapping[str, Triple]) -> bool:
    """Whether all may be targets: as far from each other in all poses, or standing still; not so what was
    nominal, a deviation, an uncertainty or a turn."""
    points = {name: _points(text, place) for name, place in places.items()}
    moving = [p for p in points.values() if _moves(p)]
    return all(_rigid(a, b) for a, b in combinations(moving, 2))


def _moves(points: Array) -> bool:
    seen = points[np.isfinite(points).all(axis=1)]
    if len(seen) < FEWEST:
        return True
    return _spread_of(seen) > STILL * float(np.linalg.norm(seen.mean(axis=0)))


def _rigid(a: Array, b: Array) -> bool:
    both = np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1)
    if both.sum() < FEWEST:
        return True
    apart = np.linalg.norm(a[both] - b[both], axis=1)
    usual, spread = float(np.median(apart)), max(_spread_of(a[both]), _spread_of(b[both]))
    return usual > SAME * spread and float(np.median(np.abs(apart - usual))) < RIGID * spread


def _spread_of(points: Array) -> float:
    return float(np.linalg.norm(points.std(axis=0)))


def _points(text: Text, place: Triple) -> Array:
    return np.stack([text.numbers(i) for i in place], axis=1)


def _turn_with(text: Text, place: Triple) -> int | None:
    """The column of w that makes x, y and z a quaternion."""
    xyz = _points(text, place)
    for i in (place[2] + 1, place[0] - 1):
        if 0 <= i < len(text.columns) and is_numbers(text.columns[i]):
            name = plain(text.header[i])
            length = np.linalg.norm(np.column_stack([xyz, text.numbers(i)]), axis=1)
            scalar = name == "q0" or "w" in (name[:1], name[-1:])
            if scalar and (np.abs(length[np.isfinite(length)] - 1) < TURN).all():
                return i
    return None


def quaternion(text: Text) -> dict[str, str | int]:
    """Columns of a 6-D measurement by their names."""
    return {our: text.name(i) for our, i in zip(QUATERNION, _turn(text), strict=False)}


def _turn(text: Text) -> tuple[int, ...]:
    """Columns w, x, y and z of a quaternion, whose names say where the scalar is: qw ... qz, q0 ... q3, or
    x, y, z beside w or q0, of length 1; none where there is none, or several are."""
    if not text.header:
        return ()
    numbers = [i for i, column in enumerate(text.columns) if is_numbers(column)]
    called = [plain(name) for name in text.header]
    for names in (QUATERNION, ("q0", "q1", "q2", "q3")):
        if all(called.count(name) == 1 and called.index(name) in numbers for name in names):
            return tuple(called.index(name) for name in names)
    turns = [
        (w, *place) for place in _triples(text, numbers).values()
        if (w := _turn_with(text, place)) is not None
    ]  # fmt: skip
    return turns[0] if len(turns) == 1 else ()


def angles(text: Text) -> dict[str, str | int]:
    """Columns of the angles of a 6-D measurement by their names, where they vary."""
    called = [plain(name) for name in text.header]
    names = next((names for names in CALLED if all(called.count(name) == 1 for name in names)), ())
    places = [called.index(name) for name in names]
    if not all(is_numbers(text.columns[i]) for i in places) or not any(map(text.varies, places)):
        return {}
    unit = unit_of(text, places[0]) or angle_unit(text, places)
    return {f"{our}_{unit}": text.name(i) for our, i in zip(ANGLES, places, strict=True)}


def measured(text: Text) -> set[int]:
    """Columns of numbers with decimals: they are no names."""
    return {
        i for i, column in enumerate(text.columns) if is_numbers(column) and not "".join(column).isdigit()
    }


def _side_by_side(text: Text, numbers: Sequence[int]) -> list[Triple]:
    """Columns of numbers, one after the other, that may be x, y and z of a table without a header: those of
    which all three vary, about as much as of any. Uncertainties, quaternions, times beside them do not."""
    places = list(zip(numbers, numbers[1:], numbers[2:], strict=False))
    worth = [min(_spread(text, i) for i in place) for place in places]
    return [place for place, least in zip(places, worth, strict=True) if least >= AS_MUCH * max(worth)]


def _spread(text: Text, index: int) -> float:
    """The standard deviation of a column; 0 where it numbers the rows."""
    values = text.numbers(index)
    seen = values[np.isfinite(values)]
    return 0.0 if counts(text.columns[index]) or not len(seen) else float(np.std(seen))
