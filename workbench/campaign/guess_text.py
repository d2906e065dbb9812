"""A table of somebody else's taken into columns, its layout guessed: separator, decimal comma, comments, what
stands above it, and where the names and units of its columns are."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files import table_units
from ..files.column_read import ABSENT, PARTED
from ..files.faults import BYTE_ORDER_MARKS, Fault, InputError, read_text
from ..files.table_rows import SEPARATORS, cells, content, split, usual_width
from ..files.tables import Layout

Array = NDArray[np.float64]

COMMENT = re.compile(r"\s*(//|#|%|!)")
NUMBER = re.compile(rf"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?|{PARTED.pattern}")
MOSTLY = 0.9  # of the rows at the end in which a column of numbers holds one
UNITS = {
    word: unit
    for unit, words in {
        "mm": "mm millimeter millimeters millimetre millimetres",
        "m": "m meter meters metre metres",
        "cm": "cm centimeter centimeters centimetre centimetres",
        "um": "um µm μm micrometer micrometers micron microns",
        "in": 'in inch inches zoll "',
        "deg": "deg ° degree degrees grad",
        "rad": "rad radian radians",
        "mrad": "mrad",
    }.items()
    for word in words.split()
}
TREE = re.compile(r"\s*(<\?xml|<\w+\s[^<>]*=|\{\s*\"|\[\s*\{)")
LENGTHS = tuple(unit for unit, known in table_units.UNITS.items() if known.dimension == "length")
BEHIND = rf"[ _.-]+({'|'.join([*dict.fromkeys(UNITS.values()), '°'])})\s*$"  # a name, as its unit
STATED = re.compile(r"\bunits?\b\W+(\w+)", re.I)  # of all columns, above the table


@dataclass(frozen=True)
class Text:
    """A table's cells: header (or none; "" where a column has no name), columns, and the layout's keys.
    counted: the first row counts the columns, 0 1 2 ..., as data frames without names are written; apart:
    the names do not stand in the line above the rows; units: a line of units below them; unit: of lengths,
    said above the table."""

    header: list[str]
    columns: list[tuple[str, ...]]
    keys: dict[str, Any]
    counted: bool = False
    apart: bool = False
    units: tuple[str, ...] = ()
    unit: str = ""

    def name(self, index: int) -> str | int:
        """How `columns` calls a column."""
        if self.counted:
            return str(index)
        name = "" if self.apart or not self.header else self.header[index]
        return name if name and self.header.count(name) == 1 else index + 1

    def largest(self, index: int) -> float:
        """The largest absolute number in a column."""
        numbers = self.numbers(index)
        return float(np.abs(numbers[np.isfinite(numbers)]).max(initial=0.0))

    def numbers(self, index: int) -> Array:
        """(rows,) of a column, NaN where it is blank."""
        return np.array([_value(cell) for cell in self.columns[index]])

    def varies(self, index: int) -> bool:
        return len(set(self.columns[index])) > 1


def _value(cell: str) -> float:
    if cell.lower() in ABSENT:
        return np.nan
    if PARTED.fullmatch(cell):
        whole, digits = re.split(r"[.,](?=\d+$)", cell)
        return float(f"{re.sub(r'[^-+0-9]', '', whole)}.{digits}")
    return float(cell.replace(",", "."))


def any_text(path: Path) -> tuple[str, dict[str, Any]]:
    """The text of a file, and the key that says its encoding where it is not UTF-8."""
    try:
        return read_text(path), {}
    except InputError:
        if not path.is_file() or path.read_bytes().startswith(tuple(BYTE_ORDER_MARKS)):
            raise
        return read_text(path, "latin-1"), {"encoding": "latin-1"}


def read(path: Path) -> Text:
    """The table in a file. Raises `InputError` where it cannot be read."""
    text, keys = any_text(path)
    if TREE.match(text):
        raise InputError(
            Fault(str(path), "is XML or JSON, no table", "write a line per row, its numbers side by side")
        )
    mark = next((m[1] for line in text.splitlines()[:20] if (m := COMMENT.match(line))), "")
    numbered = content(text, Layout(comment=mark))
    if not numbered:
        raise InputError(Fault(str(path), "is empty", "it needs a line per row"))
    lines = [line for _, line in numbered]
    separator = max(SEPARATORS, key=lambda one: _columns_of(lines, one))
    rows, _, faults = split(numbered, separator, str(path))
    if faults:
        raise InputError(faults)
    width = usual_width(rows)
    counted = len(rows[0]) > 2 and rows[0] == [str(i) for i in range(len(rows[0]))]
    start = 1 if counted else _start(rows, width)
    body = [row[:width] for row in rows[start:] if len(row) >= width]
    at, header = (None, []) if counted else _names(rows[:start], body, width)
    said = next((row for row in rows[at:start] if _are_units(row)), [])
    units = (*said, *[""] * (width - len(said)))
    apart = bool(said) or (header[-1:] == [""] and any(row[-1] for row in body))
    used = 0 if counted else start if at is None or apart else at
    above = text.split("\n")[: numbered[min(used, len(numbered) - 1)][0] - 1]
    if not header and not counted:
        header = _commented(above, mark, separator, width)
        apart = bool(header)
    body = [row for row in body if row != header]  # again between the rows
    comma = any(_has_comma(cell) for row in body for cell in row)
    keys |= {"separator": separator} if separator != "," else {}
    keys |= {"skip": len(above)} if used else {}
    keys |= ({"decimal": ","} if comma else {}) | ({"comment": mark} if mark else {})
    keys |= {} if counted or (header and not apart) else {"header": False}
    unit = next((UNITS.get(m[1].lower(), "") for line in above if (m := STATED.search(line))), "")
    columns = list(zip(*body, strict=True))
    return Text(header, columns, keys, counted, apart, units, unit if unit in LENGTHS else "")


def _start(rows: Sequence[Sequence[str]], width: int) -> int:
    """The first row that has numbers where the rows at the end have them."""
    full = [i for i, row in enumerate(rows) if len(row) >= width]
    end = [rows[i] for i in full[len(full) // 2 :]]
    held = [sum(_is_number(row[k]) for row in end) for k in range(width)]
    blank = [sum(row[k].lower() in ABSENT for row in end) for k in range(width)]
    numbers = [k for k in range(width) if held[k] and held[k] + blank[k] >= MOSTLY * len(end)]
    # time, or a number: a line of ids leaves it out
    always = next((k for k in numbers if not blank[k]), None)
    for i in full:
        said = [rows[i][k] for k in numbers]
        begins = any(map(_is_number, said)) if always is None else _is_number(rows[i][always])
        if begins and all(_is_number(cell) or cell.lower() in ABSENT for cell in said):
            return i
    return 0 if any(map(_is_number, rows[0])) else 1


def _names(
    head: Sequence[Sequence[str]], body: Sequence[Sequence[str]], width: int
) -> tuple[int | None, list[str]]:
    """The last row above the table that may name its columns, and the names: a title has fewer cells, or
    more; those of units and numbers are none."""
    for i, row in reversed(list(enumerate(head))):
        rest = any(row[width:]) or any(cell for line in body for cell in line[len(row) :])
        if not rest and any(row) and not any(map(_is_number, row)) and not _are_units(row):
            return i, [*row, *[""] * (width - len(row))][:width]
    return None, []


def _commented(above: Sequence[str], mark: str, separator: str, width: int) -> list[str]:
    """Names that stand in the last comment above the table; words between blanks may be anything."""
    line = next((line.strip() for line in reversed(above) if line.strip()), "")
    if not mark or separator == " " or not line.startswith(mark):
        return []
    try:
        names = cells(line.removeprefix(mark), separator)
    except csv.Error:
        return []
    return names if len(names) == width and all(names) and not any(map(_is_number, names)) else []


def _are_units(row: Sequence[str]) -> bool:
    said = [cell.strip("[]() ").lower() for cell in row if cell]
    return 2 * sum(word in UNITS for word in said) > len(said)


def _is_number(cell: str) -> bool:
    return NUMBER.fullmatch(cell) is not None


def _has_comma(cell: str) -> bool:
    return re.fullmatch(r"[+-]?\d+,\d+", cell) is not None or (
        PARTED.fullmatch(cell) is not None and cell.rfind(",") > cell.rfind(".")
    )


def _columns_of(lines: list[str], separator: str) -> tuple[float, bool, int]:
    """How well a separator divides all lines alike, and into how many; tabs come first, as blanks may stand
    between them, and blanks last."""
    try:
        widths = [len(cells(line, separator)) for line in lines[:200]]
    except (ValueError, csv.Error):
        return 0.0, False, 0
    most = max(set(widths), key=widths.count)
    if most == 1:
        return 0.0, False, 0
    return widths.count(most) / len(widths), separator == "\t", most


def is_numbers(column: Sequence[str]) -> bool:
    """Whether nothing else stands in it, and one does."""
    said = [cell for cell in column if cell.lower() not in ABSENT]
    return bool(said) and all(map(_is_number, said))


def odd_cell(text: Text, indices: Iterable[int]) -> str:
    """What keeps columns from being numbers: the first cell that is none; nothing where all are."""
    for i in indices:
        for cell in text.columns[i]:
            if cell.lower() not in ABSENT and not _is_number(cell):
                return f"{text.header[i]} holds {cell!r}, which is no number"
    return ""


def stated(text: Text, index: int) -> str:
    """What stands in brackets behind a column's name, in lower case."""
    said = re.search(r"[\[(]\s*(.*?)\s*[\])]", text.header[index].lower()) if text.header else None
    return said[1] if said else ""


def unit_of(text: Text, index: int) -> str | None:
    """The unit that a column's name states, [deg], (mm), _rad, or a line of units below it."""
    if text.units and (unit := UNITS.get(text.units[index].strip("[]() ").lower())):
        return unit
    if not text.header:
        return None
    behind = re.search(BEHIND, text.header[index].lower())
    return UNITS.get(stated(text, index)) or (UNITS[behind[1]] if behind else None)


def plain(name: str) -> str:
    """Letters and digits of a name without its unit."""
    bare = re.sub(r"[\[(].*?[\])]", "", name.lower())
    return re.sub(r"[^a-z0-9]", "", re.sub(BEHIND, "", bare.strip()))


def angle_unit(text: Text, indices: Sequence[int]) -> str:
    """Degrees where some joint has more than a turn in radians."""
    return "deg" if max(text.largest(i) for i in indices) > 2 * np.pi else "rad"


def length_unit(text: Text, indices: Iterable[int]) -> str:
    """As said above the table; else millimetres where some place is farther off than any is in metres."""
    return text.unit or ("mm" if max(text.largest(i) for i in indices) > 30 else "m")


def counts(column: Sequence[str]) -> bool:
    """Whether it numbers the rows."""
    return len(column) > 2 and list(column) in (
        [str(i) for i in range(first, first + len(column))] for first in (0, 1)
    )


def repeats(column: Sequence[str]) -> bool:
    return len(set(column)) < len(column)
