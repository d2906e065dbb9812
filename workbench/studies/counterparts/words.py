"""Words and numbers that the tables of measured robots share."""

from __future__ import annotations

from collections.abc import Sequence

from ...report.numbers import decimals

TITLE = "The same question on measured robots"


def micro(value: float) -> str:
    """Of a millionth, one decimal."""
    return decimals(1e6 * value, 1)


def within(values: Sequence[float], digits: int = 0) -> str:
    """From the least to the largest, or what both are."""
    low, high = decimals(min(values), digits), decimals(max(values), digits)
    return low if low == high else f"{low} to {high}"
