"""A table of somebody else's taken into columns, its layout guessed: separator, decimal comma, comments."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files.faults import BYTE_ORDER_MARKS, Fault, InputError, read_text
from ..files.table_rows import SEPARATORS, cells, content, usual_width
from ..files.tables import Layout

Array = NDArray[np.float64]

COMMENT = re.compile(r"\s*(//|#|%|!)")
NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?")
UNITS = {"mm": "mm", "m": "m", "deg": "deg", "°": "deg", "degree": "deg", "degrees": "deg", "rad": "rad"}


@dataclass(frozen=True)
class Text:
    """A table's cells: header (or none; "" where a column has no name), columns, and the layout's keys.
    counted: the first row counts the columns, 0 1 2 ..., as data frames without names are written."""

    header: list[str]
    columns: list[tuple[str, ...]]
    keys: dict[str, Any]
    counted: bool = False

    def name(self, index: int) -> str | int:
        """How `columns` calls a column."""
        if self.counted:
            return str(index)
        return (self.header[index] if self.header else "") or index + 1

    def largest(self, index: int) -> float:
        """The largest absolute number in a column."""
        numbers = self.numbers(index)
        return float(np.abs(numbers[np.isfinite(numbers)]).max(initial=0.0))

    def numbers(self, index: int) -> Array:
        """(rows,) of a column, NaN where it is blank."""
        return np.array([float(cell.replace(",", ".")) if cell else np.nan for cell in self.columns[index]])

    def varies(self, index: int) -> bool:
        return len(set(self.columns[index])) > 1


def any_text(path: Path) -> tuple[str, dict[str, Any]]:
    """The text of a file, and the key that says its encoding where it is not UTF-8."""
    try:
        return read_text(path), {}
    except InputError:
        if not path.is_file() or path.read_bytes().startswith(tuple(BYTE_ORDER_MARKS)):
            raise
        return read_text(path, "latin-1"), {"encoding": "latin-1"}


def read(path: Path) -> Text:
    text, keys = any_text(path)
    mark = next((m[1] for line in text.splitlines()[:20] if (m := COMMENT.match(line))), "")
    numbered = content(text, Layout(comment=mark))
    if not numbered:
        raise InputError(Fault(str(path), "is empty", "it needs a line per row"))
    lines = [line for _, line in numbered]
    separator = max(SEPARATORS, key=lambda one: _columns_of(lines, one))
    rows = [cells(line, separator) for line in lines]
    width = usual_width(rows)
    counted = len(rows[0]) > 2 and rows[0] == [str(i) for i in range(len(rows[0]))]
    header = [] if any(NUMBER.fullmatch(cell) for cell in rows[0]) else rows[0]
    body = [row[:width] for row in rows[counted or bool(header) :] if len(row) >= width]
    columns = list(zip(*body, strict=True))
    comma = separator != "," and any(re.fullmatch(r"[+-]?\d+,\d+", cell) for row in body for cell in row)
    keys |= {"separator": separator} if separator != "," else {}
    keys |= ({"decimal": ","} if comma else {}) | ({"comment": mark} if mark else {})
    keys |= {} if counted or header else {"header": False}
    named = [*header, *[""] * (width - len(header))] if header else []  # a title has fewer cells
    return Text(named[:width], columns, keys, counted)


def _columns_of(lines: list[str], separator: str) -> tuple[float, int]:
    """How well a separator divides all lines alike, and into how many; blanks come last."""
    try:
        widths = [len(cells(line, separator)) for line in lines[:200]]
    except ValueError:
        return 0.0, 0
    most = max(set(widths), key=widths.count)
    return (widths.count(most) / len(widths), most) if most > 1 else (0.0, 0)


def is_numbers(column: Sequence[str]) -> bool:
    return all(NUMBER.fullmatch(cell) for cell in column if cell) and any(column)


def unit_of(text: Text, index: int) -> str | None:
    """The unit that a column's name states: [deg], (mm), _rad."""
    if not text.header:
        return None
    said = re.search(r"[\[(]\s*(.*?)\s*[\])]|[ _.-](mm|m|deg|rad|°)\s*$", text.header[index].lower())
    return UNITS.get(said[1] or said[2] or "") if said else None


def angle_unit(text: Text, indices: Sequence[int]) -> str:
    """Degrees where some joint has more than a turn in radians."""
    return "deg" if max(text.largest(i) for i in indices) > 2 * np.pi else "rad"


def length_unit(text: Text, indices: Iterable[int]) -> str:
    """Millimetres where some place is farther off than any is in metres."""
    return "mm" if max(text.largest(i) for i in indices) > 30 else "m"


def counts(column: Sequence[str]) -> bool:
    """Whether it numbers the rows."""
    return len(column) > 2 and list(column) in (
        [str(i) for i in range(first, first + len(column))] for first in (0, 1)
    )


def repeats(column: Sequence[str]) -> bool:
    return len(set(column)) < len(column)
