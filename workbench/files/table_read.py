"""Read one text table into arrays in SI units, with every fault's line, column and how to mend it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import compress, islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .column_read import ColumnRead
from .faults import Fault, InputError, line_faults, read_text
from .table_columns import Column, Finding, Layout, find_columns
from .table_rows import Numbered, blocks, decimal_commas, split, torn_numbers, usual_width, wrong_layout
from .table_units import Unit
from .toml import LONGEST

Array = NDArray[np.float64]
TOP = 50  # lines at most in which a header is sought


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
        self.faults += line_faults(self.path, zip(self.lines[rows], whats, mends, strict=True))

    def add_fault_where(self, wrong: NDArray[np.bool_], name: str, what: str, mend: str) -> None:
        """One fault per row where `wrong`: "<column> <what>"."""
        rows = np.flatnonzero(wrong).tolist()
        self.add_faults(rows, [f"{self.labels[name]} {what}"] * len(rows), [mend] * len(rows))


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
    ends, endless = _scanned(text, layout)
    if not ends:
        needs = "a header and a line per row" if layout.header else "a line per row"
        table.faults.append(Fault(str(path), "is empty", f"it needs {needs}"))
        return table
    rows, lines, cannot = split(ends[:1], layout.separator, str(path))
    if cannot or endless:
        what = f"has a cell of more than {LONGEST} characters"
        mend = "is a quotation mark or a separator missing?"
        told = [(line, what, mend) for line in endless]
        table.faults = [*_cannot_be_split(text, path, layout), *line_faults(path, told)]
        return table
    width = _width(rows[0], text, layout)
    first = f"{path} line {lines[0]}"

    def find(cells: list[str]) -> Finding:
        """What the first line, split into these cells, says of the columns."""
        if not layout.header:
            return find_columns(None, len(cells), layout, wanted, str(path), place or str(path))
        return find_columns(cells, max(width, len(cells)), layout, wanted, first, place or str(path))

    finding = find(rows[0][:width] if layout.header else [""] * width)
    top = _top(text, layout) if finding.missing else []
    if (fault := wrong_layout(ends, top, layout, finding, find, first)) is not None:
        table.faults = [*_cannot_be_split(text, path, layout), fault]
        return table
    table.unused = [] if layout.columns else finding.unused
    _read_rows(table, text, layout, finding, width)
    return table


def _scanned(text: str, layout: Layout) -> tuple[Numbered, list[int]]:
    """The first and the last line, nothing where there is none; lines with a cell that is too long."""
    ends, long = Numbered(), Numbered()
    for block in blocks(text, layout):
        if block:
            ends = [ends[0] if ends else block[0], block[-1]]
        long += [item for item in block if len(item[1]) > LONGEST]
    rows, lines, _ = split(long, layout.separator, "")
    return ends, [
        line for row, line in zip(rows, lines, strict=True) if max(map(len, row), default=0) > LONGEST
    ]


def _top(text: str, layout: Layout) -> Numbered:
    """Some of the first lines."""
    return list(islice((item for block in blocks(text, layout) for item in block), TOP))


def _cannot_be_split(text: str, path: Path, layout: Layout) -> list[Fault]:
    return [fault for block in blocks(text, layout) for fault in split(block, layout.separator, str(path))[2]]


def _width(head: list[str], text: str, layout: Layout) -> int:
    """How many columns there are: as the header says, or most rows where its names do not count."""
    by_number = bool(layout.columns) and all(isinstance(where, int) for where in layout.columns.values())
    if by_number or not layout.header:
        each = (row for block in blocks(text, layout) for row in split(block, layout.separator, "")[0])
        if width := usual_width(islice(each, 1, None)):
            return width
    return max((index + 1 for index, cell in enumerate(head) if cell or not layout.header), default=0)


def _read_rows(table: Table, text: str, layout: Layout, finding: Finding, width: int) -> None:
    """The rows below the header, block by block, into the table."""
    columns = [ColumnRead(found, layout) for found in finding.found.values()]
    cannot, ragged, kept, torn = list[Fault](), list[tuple[int, str, str]](), list[int](), list[int]()
    header: list[str] | None = None
    for block in blocks(text, layout):
        rows, lines, faults = split(block, layout.separator, str(table.path))
        cannot += faults
        if layout.header and rows:
            header = rows[0] if header is None else header
            below = [row != header for row in rows]
            rows, lines = list(compress(rows, below)), list(compress(lines, below))
        if layout.separator == ",":
            torn += [line for row, line in zip(rows, lines, strict=True) if torn_numbers(row, width)]
        body, here = _rectangular(rows, lines, width, ragged)
        kept += here
        cells = list(zip(*body, strict=True)) or [()] * width
        for column in columns:
            column.add(cells[column.found.index], here)
    table.faults += [*cannot, *finding.faults]
    if not kept and not ragged:
        table.faults.append(Fault(str(table.path), "has a header but no rows", "it needs a line per row"))
        return
    table.lines = np.array(kept, dtype=np.int64)
    if len(torn) > len(kept) + 1:  # what most rows have is how the table was written
        table.faults.append(decimal_commas(f"{table.path} line {torn[0]}", len(torn)))
        ragged = [told for told in ragged if told[0] not in torn]
    if kept and ragged and not layout.header and ragged[-1][0] < kept[0]:
        mend = f"if the table begins below it, say skip = {kept[0] - 1}"
        ragged = [(line, what, mend) for line, what, _ in ragged]
    table.faults += line_faults(table.path, ragged)
    for column in columns:
        _put(table, column)


def _rectangular(
    rows: list[list[str]], lines: list[int], width: int, ragged: list[tuple[int, str, str]]
) -> tuple[list[list[str]], list[int]]:
    """The rows that have as many cells as there are columns, and their lines; empty cells at the end may be
    too many. The others are added to `ragged`."""
    body, kept = [], []
    mend = "is a separator missing or too many? text that holds one goes into quotation marks"
    for row, line in zip(rows, lines, strict=True):
        if len(row) > width and not any(row[width:]):
            row = row[:width]
        if len(row) == width:
            body.append(row)
            kept.append(line)
        else:
            ragged.append((line, f"has {len(row)} columns, not {width}", mend))
    return body, kept


def _put(table: Table, read: ColumnRead) -> None:
    name = read.found.column.name
    table.labels[name], table.units[name] = read.found.label, read.found.unit
    if read.found.column.text:
        table.texts[name] = read.texts
    else:
        table.numbers[name] = read.numbers
    table.faults += read.faults(table.path)
