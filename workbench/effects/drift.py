"""The base (or the instrument) moves with time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Depends, Effect, Param, Rest, short
from .coming_to_rest import SHARES, gone, since_start, start_and_span
from .drawn import Drawn
from .kinds import DirectEffect
from .place import Parameter
from .unnamed.campaign import Clock

RATES = ("rate_x", "rate_y", "rate_z")
EVEN, FIRST = 3e-8, 1e-7  # m/s, rad/s: usual speeds, even and before it comes to rest (0.1 mm/h, 0.4 mm/h)
UNEVEN = 0.1  # share of the way in the campaign
TURNS = ("turn_rate_x", "turn_rate_y", "turn_rate_z")


@dataclass(frozen=True)
class Drift(DirectEffect):
    """The robot's base moves by v (t − t₀), on its own axes, v in m/s; `variant` "shift+turn" turns
    it by w (t − t₀) about its origin as well, w in rad/s.

    One that creeps to rest, as a stand that warms up does, goes by v t_c (1 − exp(−(t − t₀)/t_c)): t_c is
    `constant` in s, 0: it goes evenly. An instrument that moves the other way looks the same. t₀ is the
    campaign's first instant `start`.
    """

    start: float = 0.0
    constant: float = 0.0

    cause: ClassVar[str] = "drift"
    title: ClassVar[str] = "Base or instrument drifts"
    depends: ClassVar[Depends] = frozenset({"time"})
    equation: ClassVar[str] = 'Delta X_"base" = v thin (t - t_0)'
    settings: ClassVar[tuple[str, ...]] = ("start", "constant")
    separate: ClassVar[dict[str, str]] = {
        "thermal_growth": "thermometers on the arm; four fixed targets on the floor every ten minutes",
        "foundation": "return to some poses at other times",
        "backlash": "change the side of approach in random order",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        usual = FIRST if self.constant else EVEN
        shift = tuple(Param(name, "m/s", usual, "of the base, on its own axes") for name in RATES)
        if not self.turns:
            return shift
        return shift + tuple(Param(name, "rad/s", usual, "of the base, about its origin") for name in TURNS)

    @property
    def turns(self) -> bool:
        return "turn" in self.variant

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        if problem.time is None:
            return "no column t_s: record when each pose was measured"
        return None if cls.sites(problem) else "t_s is the same for all poses"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Drift]:
        return [] if problem.time is None or np.ptp(problem.time) == 0 else cls.places(problem)

    @classmethod
    def places(cls, problem: Problem) -> Sequence[Drift]:
        start, span = start_and_span(problem)
        ways = ("shift", "shift+turn")
        even = [cls(variant=way, start=start) for way in ways]
        creeping = [
            cls(variant=f"{way} creeping {share:g}", start=start, constant=share * span)
            for way in ways
            for share in SHARES
        ]
        return even + creeping

    def _since(self, problem: Problem) -> Array:
        """(N,) [s] since the start."""
        return since_start(problem, self.start)

    def _gone(self, problem: Problem) -> Array:
        """(N,) [s] how long it would have gone at its first speed."""
        return gone(self._since(problem), self.constant)

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        """A real drift does not go evenly."""
        way = self.params[0].typical * float(np.ptp(self._gone(problem)))
        return [(UNEVEN * way / one.size, one) for one in Clock.sites(problem) if one.of_base]

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        if problem.time is None:
            return {}
        gone = self._gone(problem)[:, None]
        return {c: gone * unit for c, unit in enumerate(np.eye(len(self.params)))}

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        speed = float(np.linalg.norm(values))  # with a turn: at one metre from the base's origin
        name = "motion of the base" + (" at 1 m" if self.turns else "")
        return Drawn(self._since(problem) / 60, "time", "min", self._gone(problem) * speed, name, "m")

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        v = values[:3]
        rate = float(np.linalg.norm(v))
        along = v / rate if rate > 0 else np.full(3, 3**-0.5)
        std = float(np.sqrt(along @ covariance[:3, :3] @ along))
        return (
            Parameter("rate", rate, std, "m/s", "speed of the base, at the start"),
            *super().report(values, covariance),
        )

    def sentence(self, values: Array) -> str:
        speed = f"{short(float(np.linalg.norm(values[:3])) * 3600e6)} µm/h"
        if self.turns:
            speed += f" and turns by {short(float(np.linalg.norm(values[3:])) * 3600e6)} µrad/h"
        if self.constant:
            speed += f" at first, and comes to rest with a time constant of {self.constant / 60:.0f} min"
        return f"The base (or the instrument) drifts by {speed}."
