"""What is not printed and has to be assumed: a range for each such value, not one number."""

from __future__ import annotations

from dataclasses import dataclass

from ..report.numbers import decimals, join, significant


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
        ends = f"{_short(self.low)} … {_short(self.high)}"
        return join(ends, self.unit) + (", uniform in its logarithm" if self.log else "")


def _short(value: float) -> str:
    return decimals(value, 0) if value == round(value) and abs(value) >= 100 else significant(value, 3)
