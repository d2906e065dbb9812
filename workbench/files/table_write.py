"""Text tables in our own layout: comma, point, a header."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from .table_columns import Column

TABLE_DIGITS = 12  # significant ones: far below what an instrument sees, and short numbers stay short


def number_text(value: float, digits: int = TABLE_DIGITS) -> str:
    """A number as it goes into a table: significant digits, "" for NaN."""
    if value != value:
        return ""
    text = f"{value:.{digits}g}"
    return "0" if text == "-0" else text


def column_cells(
    column: Column, values: NDArray[np.float64], digits: int = TABLE_DIGITS
) -> tuple[str, list[str]]:
    """Name and cells of a column in its usual unit. values: (n_rows,) [SI]."""
    name, unit = column.written
    scaled = (values - unit.offset) * (1.0 / unit.factor)
    return name, [number_text(value, digits) for value in scaled.tolist()]


def table_text(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """The text of a table."""
    buffer = io.StringIO(newline="")
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return buffer.getvalue()
