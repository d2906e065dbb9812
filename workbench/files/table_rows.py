"""From text to rows of cells, each with the file's own line number."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain

from .faults import Fault
from .table_columns import Finding, Layout

SEPARATORS = (",", ";", "\t", "|", " ")
BLOCK = 1 << 20  # characters of a table that are taken apart at a time
Numbered = list[tuple[int, str]]


def content(text: str, layout: Layout) -> Numbered:
    """Line number and text of every line that is neither blank (or separators only) nor a comment."""
    return list(chain.from_iterable(blocks(text, layout)))


def blocks(text: str, layout: Layout) -> Iterator[Numbered]:
    """The same in pieces: a large table takes little more room than its numbers."""
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    empty, comment = f"{layout.separator} \t", layout.comment
    number, start = 1, 0
    while start < len(text):
        end = text.find("\n", start + BLOCK)
        lines = text[start : None if end < 0 else end].split("\n")
        yield [
            (at, line)
            for at, line in enumerate(lines, number)
            if at > layout.skip and line.strip(empty) and not (comment and line.lstrip().startswith(comment))
        ]
        number, start = number + len(lines), len(text) if end < 0 else end + 1


def cells(line: str, separator: str) -> list[str]:
    """The cells of one line; a blank as separator means any run of blanks and tabs.

    Raises `csv.Error` when a quotation mark is not closed.
    """
    if '"' in line:
        if separator == " ":
            line = line.strip().replace("\t", " ")
        reader = csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True)
        return [cell.strip() for cell in next(reader)]
    if separator == " ":
        return line.split()
    return [cell.strip() for cell in line.split(separator)]


def split(numbered: Numbered, separator: str, file: str) -> tuple[list[list[str]], list[int], list[Fault]]:
    """Rows of cells, their line numbers, and the faults of lines that cannot be split."""
    rows, lines, faults = [], [], []
    for number, line in numbered:
        try:
            rows.append(cells(line, separator))
            lines.append(number)
        except csv.Error as error:
            mend = "close the quotation mark, or take it out"
            faults.append(Fault(f"{file} line {number}", f"cannot be split: {error}", mend))
    return rows, lines, faults


def usual_width(rows: Iterable[Sequence[str]]) -> int:
    """The number of cells that most rows have; 0 without rows."""
    ((width, _),) = Counter(map(len, rows)).most_common(1) or [(0, 0)]
    return width


def wrong_layout(
    numbered: Numbered,
    top: Numbered,
    layout: Layout,
    finding: Finding,
    find: Callable[[list[str]], Finding],
    place: str,
) -> Fault | None:
    """The one fault behind many: a comment mark, a separator, lines above the table or a missing header not
    told.

    `numbered` are the first line and the last, `top` some more of the first ones; `finding` is what was found
    with the layout as told, `find` what would be found in these cells.
    """
    line = numbered[0][1]
    if finding.missing:
        if mark := re.match(r"\s*(//|#|%|!)", line):
            return Fault(
                place, f"starts with {mark[1]!r}", f'if that is a comment, say comment = "{mark[1]}"'
            )
        for separator in SEPARATORS:
            if separator != layout.separator and _fits(line, separator, finding, find):
                return Fault(
                    place, f"columns are separated by {_named(separator)}", _say(separator, numbered)
                )
        for number, other in top[1:] if layout.header else []:
            if _fits(other, layout.separator, finding, find):
                what = f"the names of the columns stand below it, in line {number}"
                return Fault(place, what, f"say skip = {number - 1}")
    last = _cells_or_none(numbered[-1][1], layout.separator)
    if layout.separator == " " and (ends := {cell[-1] for cell in last[:-1]} & {",", ";"}):
        separator = ends.pop()
        return Fault(place, f"columns are separated by {_named(separator)}", _say(separator, numbered))
    first = _cells_or_none(line, layout.separator)
    named = not layout.columns or any(isinstance(where, str) for where in layout.columns.values())
    if layout.header and (finding.missing or not named) and any(map(_is_number, first)):
        mend = "add a header, or say header = false and which column is which: columns = { pose_id = 1, ... }"
        return Fault(place, "holds numbers where the names of the columns should be", mend)
    return None


def torn_numbers(row: list[str], width: int) -> bool:
    """Whether a row has too many cells because commas, its separators, stand in its numbers as well."""
    if len(row) <= width:
        return False
    whole = [re.fullmatch(r"[+-]?\d+", cell) is not None for cell in row]
    pairs = sum(a and b and cell[0].isdigit() for a, b, cell in zip(whole, whole[1:], row[1:], strict=False))
    return len(row) - width <= pairs and not any("." in cell and _is_number(cell) for cell in row)


def decimal_commas(place: str, rows: int) -> Fault:
    """The one fault behind rows that are torn so."""
    what = f"decimal commas, and commas between the columns as well ({rows} rows): they cannot be told apart"
    mend = (
        "write the table with decimal points, or with ';' between the columns and say separator = \";\" and "
    )
    return Fault(place, what, mend + 'decimal = ","')


def _fits(line: str, separator: str, finding: Finding, find: Callable[[list[str]], Finding]) -> bool:
    other = find(_cells_or_none(line, separator))
    return len(other.found) > len(finding.found) and len(other.found) > 1


def _cells_or_none(line: str, separator: str) -> list[str]:
    try:
        return cells(line, separator)
    except csv.Error:
        return []


def _is_number(cell: str) -> bool:
    return re.fullmatch(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?", cell) is not None


def _named(separator: str) -> str:
    return {" ": "blanks", "\t": "tabs"}.get(separator, repr(separator))


def _say(separator: str, numbered: Numbered) -> str:
    text = {"\t": "\\t"}.get(separator, separator)
    comma = separator != "," and any(
        re.fullmatch(r"[+-]?\d*,\d+", cell) for cell in _cells_or_none(numbered[-1][1], separator)
    )
    return f'say separator = "{text}"' + (' and decimal = ","' if comma else "")
