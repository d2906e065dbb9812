"""Where a cause sits, and a fitted number: what effects, diagnosis and report say alike."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Parameter:
    """A fitted number with its standard deviation. `meaning` is one short sentence for people; least: what it
    cannot be below, as an amplitude cannot be negative."""

    name: str
    value: float
    std: float
    unit: str
    meaning: str = ""
    least: float = -math.inf

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval (normal)."""
        return max(self.value - 1.96 * self.std, self.least), self.value + 1.96 * self.std


@dataclass(frozen=True)
class Where:
    """Where a cause sits; absent keys are None."""

    joint: str | None = None
    other: str | None = None
    link: str | None = None
    payload: str | None = None
    order: float | None = None

    def keys(self) -> dict[str, Any]:
        """The keys that are set, in the order of `result.json`."""
        names = ("joint", "other", "link", "payload", "order")
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}

    @property
    def any_order(self) -> Where:
        """The place, at any order."""
        return self if self.order is None else replace(self, order=None)

    def __str__(self) -> str:
        return ", ".join(str(value) for key, value in self.keys().items() if key != "order")


NOWHERE = Where()  # the whole robot
ALL = "all"  # variant of a cause that joints or links have: in all of them alike
