"""Limits of torque and speed: a run stops at them, or its drives saturate and that is reported."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...robot.kinematics import Array

OnLimit = Literal["stop", "saturate"]
UNITS = {("torque", False): "N·m", ("torque", True): "N", ("speed", False): "rad/s", ("speed", True): "m/s"}


class OverLimit(Exception):
    """A drive was asked for more than its limit: joint, "torque" or "speed", when [s], how much, of how much,
    unit."""

    def __init__(self, joint: str, what: str, time: float, value: float, limit: float, unit: str) -> None:
        super().__init__(joint, what, time, value, limit, unit)
        self.time, self.joint, self.what = time, joint, what
        self.value, self.limit, self.unit = value, limit, unit

    def __str__(self) -> str:
        return (
            f"{self.joint} needs a {_word(self.what, self.unit)} of {self.value:.4g} {self.unit}, "
            f"{_percent(self.value / self.limit)} over its limit of {self.limit:.4g}"
        )


@dataclass(eq=False)
class Limits:
    """Limits (n,) of one kind, and how often and how far they were passed. `period`: between two looks
    [s]."""

    what: str
    names: tuple[str, ...]
    prismatic: NDArray[np.bool_]
    limit: Array
    on_limit: OnLimit
    period: float
    ticks: Array = field(init=False)
    worst: Array = field(init=False)
    first: Array = field(init=False)

    def __post_init__(self) -> None:
        self.ticks, self.worst = np.zeros(len(self.limit)), np.ones(len(self.limit))
        self.first = np.full(len(self.limit), np.inf)

    def within(self, values: Array, time: float) -> Array:
        """Values (n,) cut to their limits. Raises OverLimit where a run is to stop at them."""
        size = np.abs(values)
        over = size > self.limit
        if not np.count_nonzero(over):
            return values
        if self.on_limit == "stop":
            j = int(np.argmax(size / self.limit))
            raise OverLimit(
                self.names[j], self.what, time, float(size[j]), float(self.limit[j]), self._unit(j)
            )
        self.ticks += over
        self.worst = np.maximum(self.worst, size / self.limit)
        self.first = np.where(over, np.minimum(self.first, time), self.first)
        return np.clip(values, -self.limit, self.limit)

    def _unit(self, j: int) -> str:
        return UNITS[self.what, bool(self.prismatic[j])]

    def notes(self) -> tuple[str, ...]:
        """What was cut."""
        return tuple(
            f"{self.names[j]}: {_word(self.what, self._unit(j))} saturated for "
            f"{self.ticks[j] * self.period:.2g} s from {self.first[j]:.3g} s on, "
            f"{_percent(self.worst[j])} over its limit of {self.limit[j]:.4g} {self._unit(j)} at most"
            for j in map(int, np.flatnonzero(self.ticks))
        )


def _word(what: str, unit: str) -> str:
    """What a drive gives, as it is called: that of a sliding joint gives no torque."""
    return "force" if unit == UNITS["torque", True] else what


def _percent(ratio: float) -> str:
    """How far a ratio is over one, without an exponent."""
    over = 100 * (ratio - 1)
    return f"{over:.0f} %" if over >= 10 else f"{over:.2g} %"
