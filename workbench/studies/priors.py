"""What is not printed and has to be assumed: a range for each such value, not one number."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..report.numbers import Scale, join, scale, significant


@dataclass(frozen=True)
class Prior:
    """An assumed value: uniform from low to high, or uniform in its logarithm.

    words: what it is; unit: of low and high, for people; why: where the range comes from.
    """

    words: str
    low: float
    high: float
    unit: str = ""
    log: bool = False
    why: str = ""

    def __post_init__(self) -> None:
        if not self.low < self.high or (self.log and self.low <= 0):
            raise ValueError(f"{self.words}: no range from {self.low} to {self.high}")

    def at(self, share: float) -> float:
        """The value below which `share` of the range lies."""
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return float(self.low + (self.high - self.low) * share)

    @property
    def middle(self) -> float:
        """The median."""
        return self.at(0.5)

    @property
    def range(self) -> str:
        """The range in words."""
        return join(f"{self.said(self.low)} … {self.said(self.high)}", self._scale.unit) + (
            ", log-uniform" if self.log else ""
        )

    def said(self, value: float) -> str:
        """A value in the unit in which the range is said, with no more digits than it has."""
        number, power, exponent = significant(self._scale.factor * value).partition("·")
        if "." in number:
            number = number.rstrip("0").rstrip(".")
        return number + power + exponent

    @property
    def _scale(self) -> Scale:
        """A unit in which the middle of a range of magnitudes, or the end of another, is handy."""
        if not self.unit:
            return Scale(1.0, "")
        return scale(math.sqrt(self.low * self.high) if self.log else max(-self.low, self.high), self.unit)
