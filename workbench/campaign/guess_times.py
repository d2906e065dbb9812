"""Which column of somebody else's table says when each row was measured."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ..files.clock import DAY, is_time, seconds
from ..files.column_read import ABSENT
from ..files.table_units import UNITS
from .check import LONGEST_DAYS
from .guess_text import Array, Text, is_numbers, plain, stated

TIMES = {
    "s": "s sec secs second seconds sekunde sekunden",
    "ms": "ms msec millisecond milliseconds millisekunden",
    "min": "min minute minutes minuten",
    "h": "h hour hours stunden",
}  # a unit, as it is called
CALLED = (
    "time", "t", "timestamp", "zeit", "zeitstempel", "datetime", "dateandtime", "uhrzeit", "elapsed",
    "elapsedtime",
)  # fmt: skip
ONWARDS = 0.95  # of the rows, that are not earlier than the one before
EPOCH = {"s": (1e9, 1e10), "ms": (1e12, 1e13)}  # since 1970: numbers that say their unit themselves


def when(text: Text, taken: Collection[int]) -> dict[str, str | int]:
    """The column of the time, with its unit: times of day with their dates or without, wherever they are;
    numbers, where their name says that they are a time, and of what unit. Nothing where none, or several,
    are, and where time goes back and forth."""
    found = dict[str, int]()
    for i, column in enumerate(text.columns):
        if i in taken or not text.varies(i):
            continue
        if all(is_time(cell) for cell in column if cell.lower() not in ABSENT):
            unit = "clock"
        elif not is_numbers(column) or not (unit := _unit(text, i)):
            continue
        values = seconds(column) if unit == "clock" else UNITS[unit].factor * text.numbers(i)
        if _goes_on(values):
            found[unit] = -1 if unit in found else i
    if len(found) != 1 or -1 in found.values():
        return {}
    ((unit, i),) = found.items()
    return {f"t_{unit}": text.name(i)}


def _unit(text: Text, index: int) -> str:
    """The unit of a column of numbers that is called a time; nothing of another."""
    if not text.header:
        return ""
    name = plain(text.header[index])
    for unit, words in TIMES.items():
        behind = [word for word in words.split() if name.endswith(word) and name.removesuffix(word) in CALLED]
        if (name in CALLED and stated(text, index) in words.split()) or behind:
            return unit
    largest = text.largest(index)
    since = [unit for unit, (least, most) in EPOCH.items() if least < largest < most]
    return since[0] if name in CALLED and since else ""


def _goes_on(values: Array) -> bool:
    """Whether it may be the time of one row after the other."""
    known = values[np.isfinite(values)]
    steps = np.diff(known)
    return bool(len(steps) and np.mean(steps >= 0) >= ONWARDS and 0 < np.ptp(known) < LONGEST_DAYS * DAY)
