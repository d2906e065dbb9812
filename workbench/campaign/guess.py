"""How somebody's own tables are laid out, guessed from their text: what `workbench init` proposes.

A guess goes into `campaign.toml`, where people read it; `load_campaign` never guesses.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..files.faults import BYTE_ORDER_MARKS, Fault, InputError, read_text
from ..files.table_rows import SEPARATORS, cells, content, usual_width
from ..files.tables import Layout
from ..robot.chain import MovingJoint

COMMENT = re.compile(r"\s*(//|#|%|!)")
NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?")
POSE = (
    "poseid", "pose", "posenr", "poseno", "posename", "id", "nr", "no", "nummer", "index", "group", "gruppe",
    "name", "point", "punkt", "punktnr", "messpunkt", "stellung",
)  # fmt: skip
TARGET = (
    "target", "smr", "reflector", "reflektor", "marker", "marke", "ziel", "targetname", "pointname",
    "punktname", "point", "punkt", "name",
)  # fmt: skip
UNITS = {"mm": "mm", "m": "m", "deg": "deg", "°": "deg", "degree": "deg", "degrees": "deg", "rad": "rad"}
JOINT = re.compile(r"(?:a|j|q|ax|axis|achse|joint|jt|theta|actualq|targetq)(?:pos|cmd)?0?(\d)(?:pos|cmd)?")


@dataclass
class Guessed:
    """Keys for `[poses]` or `[points]`; lacking: our columns that were not found, among `header`."""

    keys: dict[str, Any] = field(default_factory=dict)
    lacking: list[str] = field(default_factory=list)
    header: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class _Text:
    """A table's cells: header (or none), columns, and the layout's keys."""

    header: list[str]
    columns: list[tuple[str, ...]]
    keys: dict[str, Any]

    def name(self, index: int) -> str | int:
        """How `columns` calls a column."""
        return self.header[index] if self.header else index + 1

    def largest(self, index: int) -> float:
        """The largest absolute number in a column."""
        return max((abs(float(cell.replace(",", "."))) for cell in self.columns[index] if cell), default=0.0)


def guess_poses(path: Path, joints: Sequence[MovingJoint]) -> Guessed:
    """Keys for the table of a robot's joints. Raises `InputError` where the file cannot be read."""
    text = _read(path)
    found = Guessed(dict(text.keys), header=text.header)
    columns: dict[str, str | int] = {}
    numbers = _joint_columns(text, [joint.name for joint in joints])
    for i, joint in enumerate(joints, 1):
        if i not in numbers:
            found.lacking.append(f"joint {i}")
            continue
        index = numbers[i]
        slides = joint.kind == "prismatic"
        usual = ("mm" if text.largest(index) > 5 else "m") if slides else None
        unit = _unit(text, index) or usual or _angle_unit(text, list(numbers.values()))
        columns[f"q{i}_{unit}"] = text.name(index)
    identity = _first(text, POSE, set(numbers.values()))
    if identity is not None and len(set(text.columns[identity])) == len(text.columns[identity]):
        columns = {"pose_id": text.name(identity), **columns}
    return _mapped(found, columns)


def guess_points(path: Path) -> Guessed:
    """Keys for the table of the instrument's points. Raises `InputError` where the file cannot be read."""
    text = _read(path)
    found = Guessed(dict(text.keys), header=text.header)
    places = _triples(text)
    if not places:
        found.lacking += ["x", "y", "z"]
        return found
    taken = {index for triple in places.values() for index in triple}
    lengths = [text.largest(index) for index in taken]
    unit = _unit(text, min(taken)) or ("mm" if max(lengths) > 30 else "m")
    columns: dict[str, str | int] = {}
    if (identity := _first(text, POSE, taken)) is not None:
        columns["pose_id"] = text.name(identity)
        taken.add(identity)
    if len(places) == 1:
        if (target := _first(text, TARGET, taken)) is not None and _repeats(text.columns[target]):
            columns["target"] = text.name(target)
        (triple,) = places.values()
        columns |= {f"{axis}_{unit}": text.name(i) for axis, i in zip("xyz", triple, strict=True)}
        return _mapped(found, columns)
    found.keys["wide"] = {name: [text.name(i) for i in triple] for name, triple in places.items()}
    if unit != "mm":
        found.keys["units"] = {f"{axis}_mm": unit for axis in "xyz"}
    return _mapped(found, columns)


def _mapped(found: Guessed, columns: dict[str, str | int]) -> Guessed:
    """With the mapping, unless all names are ours already."""
    if any(name != where for name, where in columns.items()):
        found.keys["columns"] = columns
    return found


def _read(path: Path) -> _Text:
    keys: dict[str, Any] = {}
    try:
        text = read_text(path)
    except InputError:
        if not path.is_file() or path.read_bytes().startswith(tuple(BYTE_ORDER_MARKS)):
            raise
        text = read_text(path, "latin-1")
        keys["encoding"] = "latin-1"
    mark = next((m[1] for line in text.splitlines()[:20] if (m := COMMENT.match(line))), "")
    numbered = content(text, Layout(comment=mark))
    if not numbered:
        raise InputError(Fault(str(path), "is empty", "it needs a line per row"))
    lines = [line for _, line in numbered]
    separator = max(SEPARATORS, key=lambda one: _columns_of(lines, one))
    rows = [cells(line, separator) for line in lines]
    width = usual_width(rows)
    header = [] if any(NUMBER.fullmatch(cell) for cell in rows[0]) else rows[0]
    body = [row[:width] for row in rows[bool(header) :] if len(row) >= width]
    columns = list(zip(*body, strict=True))
    comma = separator != "," and any(re.fullmatch(r"[+-]?\d+,\d+", cell) for row in body for cell in row)
    keys |= {"separator": separator} if separator != "," else {}
    keys |= ({"decimal": ","} if comma else {}) | ({"comment": mark} if mark else {})
    keys |= {} if header else {"header": False}
    return _Text(header[:width], columns, keys)


def _columns_of(lines: list[str], separator: str) -> tuple[float, int]:
    """How well a separator divides all lines alike, and into how many; blanks come last."""
    try:
        widths = [len(cells(line, separator)) for line in lines[:200]]
    except ValueError:
        return 0.0, 0
    most = max(set(widths), key=widths.count)
    return (widths.count(most) / len(widths), most) if most > 1 else (0.0, 0)


def _is_numbers(column: Sequence[str]) -> bool:
    return all(NUMBER.fullmatch(cell) for cell in column if cell) and any(column)


def _plain(name: str) -> str:
    """Letters and digits of a name without its unit."""
    bare = re.sub(r"[\[(].*?[\])]", "", name.lower())
    bare = re.sub(r"[ _.-]+(mm|m|deg|rad|°)$", "", bare.strip())
    return re.sub(r"[^a-z0-9]", "", bare)


def _unit(text: _Text, index: int) -> str | None:
    """The unit that a column's name states: [deg], (mm), _rad."""
    if not text.header:
        return None
    said = re.search(r"[\[(]\s*(.*?)\s*[\])]|[ _.-](mm|m|deg|rad|°)\s*$", text.header[index].lower())
    return UNITS.get(said[1] or said[2] or "") if said else None


def _angle_unit(text: _Text, indices: Sequence[int]) -> str:
    """Degrees where some joint has more than a turn in radians."""
    return "deg" if max(text.largest(i) for i in indices) > 2 * np.pi else "rad"


def _joint_columns(text: _Text, names: Sequence[str]) -> dict[int, int]:
    """Joint (from 1) → column: by the robot's own names, by names with a number, or all columns in order."""
    numbers = [i for i, column in enumerate(text.columns) if _is_numbers(column)]
    if not text.header:
        rest = numbers[-len(names) :]
        return dict(enumerate(rest, 1)) if len(rest) == len(names) else {}
    plain = {i: _plain(text.header[i]) for i in numbers}
    own = {_plain(name): j for j, name in enumerate(names, 1)} | {
        _plain(name).removesuffix("joint"): j for j, name in enumerate(names, 1)
    }
    found = {own[name]: i for i, name in reversed(plain.items()) if name in own}
    if len(found) == len(names):
        return found
    counted = [(int(match[1]), i) for i, name in plain.items() if (match := JOINT.fullmatch(name))]
    first = min((number for number, _ in counted), default=1)
    return {number + 1 - first: i for number, i in reversed(counted) if number + 1 - first <= len(names)}


def _triples(text: _Text) -> dict[str, tuple[int, int, int]]:
    """Target → columns of x, y, z."""
    numbers = [i for i, column in enumerate(text.columns) if _is_numbers(column)]
    if not text.header:
        return {"": (numbers[-3], numbers[-2], numbers[-1])} if len(numbers) >= 3 else {}
    axes: dict[str, dict[str, int]] = {}
    for i in numbers:
        plain = _plain(text.header[i])
        match = re.fullmatch(r"([xyz])(\w*)|(\w*?)([xyz])", plain)
        if match:
            axis, name = (match[1], match[2]) if match[1] else (match[4], match[3])
            axes.setdefault(name, {}).setdefault(axis, i)
    whole = {name: (a["x"], a["y"], a["z"]) for name, a in axes.items() if len(a) == 3}
    if "" in whole or len(whole) == 1:
        return {"": whole.get("", next(iter(whole.values())))}
    return {f"T{name}" if name.isdigit() else name.upper(): triple for name, triple in whole.items()}


def _first(text: _Text, names: Sequence[str], taken: set[int]) -> int | None:
    """The first column that is called so; without a header, the first one that is left."""
    left = [i for i in range(len(text.columns)) if i not in taken]
    if not text.header:
        return left[0] if left else None
    plain = {_plain(text.header[i]): i for i in reversed(left)}
    return next((plain[name] for name in names if name in plain), None)


def _repeats(column: Sequence[str]) -> bool:
    return len(set(column)) < len(column)
