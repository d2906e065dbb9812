"""Read one text table into arrays in SI units, with every fault's line, column and how to mend it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .faults import Fault, InputError, counted, read_text
from .measure import LARGEST
from .table_columns import Column, Finding, Found, Layout, find_columns
from .table_rows import content, split, usual_width, wrong_layout
from .table_units import Unit
from .toml import LONGEST

Array = NDArray[np.float64]


def _no_lines() -> NDArray[np.int64]:
    return np.zeros(0, dtype=np.int64)


@dataclass
class Table:
    """One table as read. Columns are addressed by their name without unit ("q1", "pose_id").

    lines: (n_rows,) the file's own line of each row; numbers: (n_rows,) each, SI, NaN where the
    cell is empty or wrong; labels: what messages call a column; units: the file's own; unused: names in
    a header of our own layout that nobody wants.
    """

    path: Path
    lines: NDArray[np.int64] = field(default_factory=_no_lines)
    numbers: dict[str, Array] = field(default_factory=dict)
    texts: dict[str, list[str]] = field(default_factory=dict)
    labels: dict[str, str] = field(default_factory=dict)
    units: dict[str, Unit] = field(default_factory=dict)
    unused: list[str] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.lines)

    def add_faults(self, rows: Sequence[int], whats: Iterable[str], mends: Iterable[str]) -> None:
        """One fault per row (its index in the table), in the order of the file."""
        self.faults += line_faults(self.path, self.lines[rows], whats, mends)

    def add_fault_where(self, wrong: NDArray[np.bool_], name: str, what: str, mend: str) -> None:
        """One fault per row where `wrong`: "<column> <what>"."""
        rows = np.flatnonzero(wrong).tolist()
        self.add_faults(rows, [f"{self.labels[name]} {what}"] * len(rows), [mend] * len(rows))


def line_faults(path: Path, lines: Iterable[int], whats: Iterable[str], mends: Iterable[str]) -> list[Fault]:
    """One fault per line: the first ones in full, the rest counted."""
    told = zip(lines, whats, mends, strict=True)
    return counted([Fault(f"{path} line {line}", what, mend) for line, what, mend in told])


def read_table(path: Path, layout: Layout, wanted: Sequence[Column], place: str = "") -> Table:
    """Read a table. Its faults, if any, are in the result, so that a caller can collect them all.

    `place` says where the layout stands, for messages about it ("campaign.toml: points").
    """
    try:
        text = read_text(path, layout.encoding)
    except InputError as error:
        return Table(path, faults=list(error.faults))
    return parse_table(text, path, layout, wanted, place)


def parse_table(text: str, path: Path, layout: Layout, wanted: Sequence[Column], place: str = "") -> Table:
    """The table in a text; `path` is what its faults call it. See `read_table`."""
    table = Table(path)
    numbered = content(text, layout)
    rows, lines, table.faults = split(numbered, layout.separator, str(path))
    if not rows or lines[0] != numbered[0][0]:
        needs = "a header and a line per row" if layout.header else "a line per row"
        table.faults = table.faults or [Fault(str(path), "is empty", f"it needs {needs}")]
        return table
    if endless := [line for row, line in zip(rows, lines, strict=True) if max(map(len, row)) > LONGEST]:
        what, mend = (
            f"has a cell of more than {LONGEST} characters",
            "is a quotation mark or a separator missing?",
        )
        count = len(endless)
        table.faults += line_faults(path, endless, [what] * count, [mend] * count)
        return table
    start = 1 if layout.header else 0
    width = _width(rows, layout)
    first = f"{path} line {lines[0]}"

    def find(cells: list[str]) -> Finding:
        """What the first line, split into these cells, says of the columns."""
        if not layout.header:
            return find_columns(None, len(cells), layout, wanted, str(path), place or str(path))
        return find_columns(cells, max(width, len(cells)), layout, wanted, first, place or str(path))

    finding = find(rows[0][:width] if layout.header else [""] * width)
    if (fault := wrong_layout(numbered, layout, finding, find, first)) is not None:
        table.faults.append(fault)
        return table
    table.faults += finding.faults
    table.unused = [] if layout.columns else finding.unused
    if len(rows) == start:
        table.faults.append(Fault(str(path), "has a header but no rows", "it needs a line per row"))
        return table
    body = _rectangular(table, rows[start:], lines[start:], width)
    columns = list(zip(*body, strict=True)) or [()] * width
    for found in finding.found.values():
        _read_column(table, found, columns[found.index], layout)
    return table


def _width(rows: list[list[str]], layout: Layout) -> int:
    """How many columns there are: as the header says, or most rows where its names do not count."""
    by_number = bool(layout.columns) and all(isinstance(where, int) for where in layout.columns.values())
    if len(rows) > 1 and (by_number or not layout.header):
        return usual_width(rows[1:])
    return max((index + 1 for index, cell in enumerate(rows[0]) if cell or not layout.header), default=0)


def _rectangular(table: Table, rows: list[list[str]], lines: list[int], width: int) -> list[list[str]]:
    """The rows that have as many cells as there are columns; empty cells at the end may be too many."""
    body, kept, ragged = [], [], []
    for row, line in zip(rows, lines, strict=True):
        if len(row) > width and not any(row[width:]):
            row = row[:width]
        if len(row) == width:
            body.append(row)
            kept.append(line)
        else:
            ragged.append((line, f"has {len(row)} columns, not {width}"))
    table.lines = np.array(kept, dtype=np.int64)
    mend = "is a separator missing or too many? text that holds one goes into quotation marks"
    table.faults += line_faults(
        table.path, [line for line, _ in ragged], [what for _, what in ragged], [mend] * len(ragged)
    )
    return body


def _read_column(table: Table, found: Found, cells: Sequence[str], layout: Layout) -> None:
    column = found.column
    table.labels[column.name], table.units[column.name] = found.label, found.unit
    if column.text:
        table.texts[column.name] = list(cells)
        wrong = [] if column.blank else [row for row, cell in enumerate(cells) if not cell]
    else:
        values = _numbers(cells, layout.decimal)
        table.numbers[column.name] = found.sign * values * found.unit.factor + found.unit.offset
        wrong = np.flatnonzero(~np.isfinite(values)).tolist()
        if not column.wild:
            huge = np.isfinite(values) & (np.abs(values) > LARGEST)
            table.add_fault_where(huge, column.name, "is beyond all measure", "mend the number")
        if column.blank:
            wrong = [row for row in wrong if cells[row]]
    told = [_tell(found, cells[row], layout) for row in wrong]
    table.add_faults(wrong, [what for what, _ in told], [mend for _, mend in told])


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
    mend = column.mend or ("leave the cell empty where there is none" if column.blank else "")
    if not cell:
        return f"{found.label} is empty", mend
    other = "," if layout.decimal == "." else "."
    if re.fullmatch(rf"[+-]?\d*\{other}\d+([eE][+-]?\d+)?", cell):
        return f"{found.label} is {cell!r}, not a number", f'say decimal = "{other}"'
    kind = (
        "a finite number" if np.isinf(_number(cell, layout.decimal)) or cell.lower() == "nan" else "a number"
    )
    return f"{found.label} is {cell!r}, not {kind}", mend
