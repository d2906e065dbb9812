"""The base (or the instrument), or the tool on the flange, moves with time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Depends, Effect, Param, Rest, motion_said, short
from .coming_to_rest import SHARES, gone, since_start, start_and_span
from .drawn import Drawn
from .kinds import DirectEffect
from .place import Parameter
from .travel import rms
from .unnamed.base import each
from .unnamed.campaign import Clock, flange_of, waves_over, waves_shown, weights_of_waves

WAYS = ("shift", "shift+turn", "tool")
RATES = ("rate_x", "rate_y", "rate_z")
EVEN, FIRST = 3e-8, 1e-7  # m/s, rad/s: usual speeds, even and before it comes to rest (0.1 mm/h, 0.4 mm/h)
UNEVEN = 0.1  # share of the way in the campaign
FREELY = 3e-5  # rad, m: a usual way by no law
TURNS = ("turn_rate_x", "turn_rate_y", "turn_rate_z")


@dataclass(frozen=True)
class Drift(DirectEffect):
    """The robot's base moves by v (t − t₀), on its own axes, v in m/s; `variant` "shift+turn" turns
    it by w (t − t₀) about its origin as well, w in rad/s; "tool" is both of the tool, on the flange's axes.

    One that creeps to rest, as a stand that warms up does, goes by v t_c (1 − exp(−(t − t₀)/t_c)): t_c is
    `constant` in s, 0: it goes evenly. An instrument that moves the other way looks the same. t₀ is the
    campaign's first instant `start`. One that goes "freely", there and back, by shifts and breaks, follows no
    law (`FreeDrift`): what it does at other times nobody knows.
    """

    start: float = 0.0
    constant: float = 0.0

    cause: ClassVar[str] = "drift"
    title: ClassVar[str] = "Base, instrument or tool drifts"
    depends: ClassVar[Depends] = frozenset({"time"})
    equation: ClassVar[str] = 'Delta X_"base" = v thin (t - t_0)'
    settings: ClassVar[tuple[str, ...]] = ("start", "constant")
    separate: ClassVar[dict[str, str]] = {
        "thermal_growth": "thermometers on the arm; four targets on the base every ten minutes",
        "foundation": "return to some poses at other times",
        "backlash": "change the side of approach in random order",
    }

    @property
    def params(self) -> tuple[Param, ...]:
        usual = FIRST if self.constant else EVEN
        of, frame = f"of the {self.what}", "flange" if self.of_tool else "base"
        shift = tuple(Param(name, "m/s", usual, f"{of}, on the {frame}'s axes") for name in RATES)
        if not self.turns:
            return shift
        turn = tuple(Param(name, "rad/s", usual, f"{of}, about the {frame}'s origin") for name in TURNS)
        return shift + turn

    @property
    def of_tool(self) -> bool:
        return self.variant.startswith("tool")

    @property
    def what(self) -> str:
        """What moves."""
        return "tool" if self.of_tool else "base"

    @property
    def turns(self) -> bool:
        return self.of_tool or "turn" in self.variant

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        if problem.time is None:
            return "no column t_s: record when each pose was measured"
        return None if cls.sites(problem) else "t_s is the same for all poses"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Drift]:
        return [*cls.places(problem), *FreeDrift.over(problem)] if problem.time_passes else []

    @classmethod
    def places(cls, problem: Problem) -> Sequence[Drift]:
        start, span = start_and_span(problem)
        even = [Drift(variant=way, start=start) for way in WAYS]
        creeping = [
            Drift(variant=f"{way} creeping {share:g}", start=start, constant=share * span)
            for way in WAYS
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
        return [(UNEVEN * way / one.size, one) for one in Clock.of(problem) if one.of_base != self.of_tool]

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        if problem.time is None:
            return {}
        columns = flange_of(problem) if self.of_tool else range(6 if self.turns else 3)
        return each(columns, self._course(problem.time))

    def _course(self, time: Array) -> Array:
        """(N, k) how each motion goes in time (N,) [s], per unit of each of its parameters."""
        return gone(time - self.start, self.constant)[:, None]

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        # with a turn: at one metre from the origin
        name = f"motion of the {self.what}" + (" at 1 m" if self.turns else "")
        moved = [basis @ values for basis in self.motion(problem).values()]
        gone = np.sign(self._gone(problem)) * np.linalg.norm(moved, axis=0)
        return Drawn(self._since(problem) / 60, "time", "min", gone, name, "m")

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        v = values[:3]
        rate = float(np.linalg.norm(v))
        along = v / rate if rate > 0 else np.full(3, 3**-0.5)
        std = float(np.sqrt(along @ covariance[:3, :3] @ along))
        return (
            Parameter("rate", rate, std, "m/s", f"speed of the {self.what}, at the start", least=0.0),
            *super().report(values, covariance),
        )

    @property
    def what_or(self) -> str:
        """What moves, or does so as far as anybody can tell."""
        return "tool" if self.of_tool else "base (or the instrument)"

    def sentence(self, values: Array) -> str:
        speed = f"{short(float(np.linalg.norm(values[:3])) * 3600e6)} µm/h"
        if self.turns:
            speed += f" and turns by {short(float(np.linalg.norm(values[3:])) * 3600e6)} µrad/h"
        if self.constant:
            speed += f" at first, and comes to rest with a time constant of {self.constant / 60:.0f} min"
        return f"The {self.what_or} drifts by {speed}."


@dataclass(frozen=True)
class FreeDrift(Drift):
    """A drift by no law: so many waves in time, `highest`, for each motion, as large as `size` [m, rad]."""

    highest: float = 1.0
    size: float = FREELY

    rare: ClassVar[bool] = True
    lasting: ClassVar[bool] = False

    @classmethod
    def over(cls, problem: Problem) -> Sequence[FreeDrift]:
        """All ways to drift, in as many waves as the campaign can show."""
        start, _ = start_and_span(problem)
        return [
            cls(variant=f"{way} freely", start=start, highest=highest)
            for highest in waves_shown(problem)
            for way in WAYS
        ]

    @property
    def params(self) -> tuple[Param, ...]:
        return weights_of_waves(self.size, self.highest, 6 if self.turns else 3)

    def sized(self, scale: float) -> FreeDrift:
        return replace(self, size=scale * self.size)

    def companions(self, problem: Problem) -> Sequence[tuple[float, Effect]]:
        return []

    def _course(self, time: Array) -> Array:
        return waves_over(time, self.highest)

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        size, std = self._shift(values, covariance)
        return (
            Parameter(
                "amplitude", size, std, "m", f"RMS of the {self.what}'s shift in the campaign", least=0.0
            ),
        )

    def _shift(self, values: Array, covariance: Array) -> tuple[float, float]:
        """RMS over the campaign of how far it shifts [m], and its standard deviation."""
        part = slice(3 * int(self.highest))
        return rms(values[part], covariance[part, part])

    def sentence(self, values: Array) -> str:
        size, _ = self._shift(values, np.zeros((len(values), len(values))))
        moved = motion_said(size, sliding=True)
        return f"The {self.what_or} moves in the course of the campaign, by {moved} RMS."
