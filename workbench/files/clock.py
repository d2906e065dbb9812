"""Times as instruments and controllers write them: with the date or without, as seconds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

DAY = 86400.0  # s
CLOCK = re.compile(
    r"(?:(\d+)([-/.])(\d+)\2(\d+)[T ,]+)?(\d{1,2}):(\d\d)(?::(\d\d(?:[.,]\d+)?))?\s*([AP]M)?Z?", re.I
)
ORDERS = ("day", "month")  # what comes first where the year does not


def is_time(cell: str) -> bool:
    """Whether it is a time of day, with a date before it or without."""
    return np.isfinite(_read(cell, "day")) or np.isfinite(_read(cell, "month"))


def seconds(cells: Sequence[str]) -> NDArray[np.float64]:
    """(N,) [s] from the earliest of them; NaN where a cell is no time.

    Of 3/4/2026 nobody knows whether it is in March or April: it is what makes the whole shorter. Without
    dates a time that is earlier than the one before it by more than half a day is of the next day.
    """
    ways = [np.array([_read(cell, first) for cell in cells]) for first in ORDERS]
    whole = [way for way in ways if np.isfinite(way).sum() == max(np.isfinite(other).sum() for other in ways)]
    found = min(whole, key=lambda way: np.ptp(way[np.isfinite(way)]) if np.isfinite(way).any() else 0.0)
    if not any(_dated(cell) for cell in cells):
        there = np.flatnonzero(np.isfinite(found))
        for before, after in pairwise(there.tolist()):
            if found[after] < found[before] - DAY / 2:
                found[after:] += DAY
    return np.asarray(found - np.nanmin(found)) if np.isfinite(found).any() else found


def _dated(cell: str) -> bool:
    match = CLOCK.fullmatch(cell.strip())
    return match is not None and match[1] is not None


def _read(cell: str, first: str) -> float:
    """Seconds from the beginning of the calendar, or of the day where there is no date."""
    match = CLOCK.fullmatch(cell.strip())
    if match is None:
        return np.nan
    hour, minute, second = int(match[5]), int(match[6]), float((match[7] or "0").replace(",", "."))
    if half := (match[8] or "").upper():
        if not 1 <= hour <= 12:
            return np.nan
        hour = hour % 12 + 12 * (half == "PM")
    if hour > 23 or minute > 59 or second >= 61:
        return np.nan
    days = 0
    if match[1] is not None:
        a, b, c = int(match[1]), int(match[3]), int(match[4])
        year, month, day = (a, b, c) if a > 31 else (c, b, a) if first == "day" else (c, a, b)
        try:
            days = date(year + 2000 * (year < 100), month, day).toordinal()
        except ValueError:
            return np.nan
    return DAY * days + 3600.0 * hour + 60.0 * minute + second
