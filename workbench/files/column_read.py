"""One column of a table, read block by block: its values in SI units, and the cells that are wrong."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .clock import is_time, seconds
from .faults import Fault, line_faults
from .measure import LARGEST
from .table_columns import Found, Layout
from .table_units import CLOCK

Array = NDArray[np.float64]

ABSENT = ("", "-", "--", "---", "nan", "n/a", "#n/a", "na", "null", "none")  # what stands where nothing is
PARTED = re.compile(r"[+-]?\d{1,3}(,\d{3})+\.\d+|[+-]?\d{1,3}(\.\d{3})+,\d+|[+-]?\d{1,3}([' ]\d{3})+[.,]\d+")


@dataclass
class ColumnRead:
    """What was read of a column. values: a piece per block, NaN where a cell is empty or wrong; texts: of a
    column of text, or of times of day, instead; huge: lines with a number beyond all measure; wrong: lines,
    what is wrong there and how to mend it."""

    found: Found
    layout: Layout
    values: list[Array] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)
    huge: list[int] = field(default_factory=list)
    wrong: list[tuple[int, str, str]] = field(default_factory=list)

    def add(self, cells: Sequence[str], lines: Sequence[int]) -> None:
        """The next block: its cells, and their lines in the file."""
        column = self.found.column
        if column.text:
            self.texts += map(
                sys.intern, cells
            )  # a pose's name stands in two tables, a target's in many rows
            rows = [] if column.blank else [row for row, cell in enumerate(cells) if not cell]
        else:
            rows = self._add_times(cells) if self.found.unit is CLOCK else self._add_numbers(cells, lines)
            if column.blank:
                rows = [row for row in rows if cells[row].lower() not in ABSENT]
        self.wrong += [(lines[row], *_tell(self.found, cells[row], self.layout)) for row in rows]

    def _add_times(self, cells: Sequence[str]) -> list[int]:
        """Rows of those that are none. What they are in seconds, all of them say together."""
        self.texts += cells
        return [row for row, cell in enumerate(cells) if not is_time(cell)]

    def _add_numbers(self, cells: Sequence[str], lines: Sequence[int]) -> list[int]:
        """Rows of those that are none."""
        values = _numbers(cells, self.layout.decimal)
        self.values.append(self.found.sign * values * self.found.unit.factor + self.found.unit.offset)
        if not self.found.column.wild:
            huge = np.isfinite(values) & (np.abs(values) > LARGEST)
            self.huge += [lines[row] for row in np.flatnonzero(huge).tolist()]
        return np.flatnonzero(~np.isfinite(values)).tolist()

    def faults(self, path: Path) -> list[Fault]:
        """The faults of the cells, in the order of the file."""
        what, mend = f"{self.found.label} is beyond all measure", "mend the number"
        return [
            *line_faults(path, [(line, what, mend) for line in self.huge]),
            *line_faults(path, self.wrong),
        ]

    @property
    def numbers(self) -> Array:
        """(n_rows,) [SI]."""
        if self.found.unit is CLOCK:
            return seconds(self.texts)
        return np.concatenate([np.zeros(0), *self.values])


def _numbers(cells: Sequence[str], decimal: str) -> Array:
    """The cells as numbers, NaN where they are none."""
    try:
        if decimal == "." and not any("_" in cell for cell in cells):
            return np.array([float(cell) for cell in cells], dtype=np.float64)
    except ValueError:
        pass
    return np.array([_number(cell, decimal) for cell in cells], dtype=np.float64)


def _number(cell: str, decimal: str) -> float:
    if "_" in cell or (decimal == "," and "." in cell):
        return np.nan
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return np.nan


def _tell(found: Found, cell: str, layout: Layout) -> tuple[str, str]:
    """What is wrong with a cell, and how to mend it."""
    column = found.column
    if found.unit is CLOCK and cell:
        return f"{found.label} is {cell!r}, not a time", "write 14:03:05, or 2026-11-30 14:03:05"
    mend = column.mend or ("leave the cell empty where there is none" if column.blank else "")
    if not cell:
        return f"{found.label} is empty", mend
    other = "," if layout.decimal == "." else "."
    if re.fullmatch(rf"[+-]?\d*\{other}\d+([eE][+-]?\d+)?", cell):
        return f"{found.label} is {cell!r}, not a number", f'say decimal = "{other}"'
    if PARTED.fullmatch(cell):
        mend = "write it without a sign between the thousands"
    kind = (
        "a finite number" if np.isinf(_number(cell, layout.decimal)) or cell.lower() == "nan" else "a number"
    )
    return f"{found.label} is {cell!r}, not {kind}", mend
