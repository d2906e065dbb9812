"""Motions of base and tool: with time, temperature, payload, attitude."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..base import Depends, Param
from ..coming_to_rest import SHARES, SOONEST, gone, share_gone, since_start, start_and_span
from ..kinds import DirectEffect
from ..place import Where
from .base import Unnamed, each, moving

WAVES_IN_TIME = 10
VISITS_PER_WAVE = 5  # a joint position that is measured several times on end is one look at time
WITH_TIME = 0.8  # correlation from which a joint goes along with time


@dataclass(frozen=True)
class Clock(Unnamed, DirectEffect):
    """Base or tool (`variant`) moves with the order of measurement, where no time was recorded: else that has
    a name, beside which it stands. highest: number of its waves."""

    variant: str = "base"
    size: float = 3e-5
    highest: float = float(WAVES_IN_TIME)

    depends: ClassVar[Depends] = frozenset({"time"})
    settings: ClassVar[tuple[str, ...]] = ("size", "highest")
    lacks: ClassVar[str] = "record when each pose was measured (t_s)"

    @property
    def functions(self) -> int:
        return self.motions * int(self.highest)

    @property
    def motions(self) -> int:
        """Number of what moves, each by waves of its own."""
        return 6

    @property
    def variable(self) -> str:
        return "time" if self.variant.endswith("time") else "the order of measurement"

    @property
    def unit(self) -> str:
        return "s" if self.variant.endswith("time") else "1"

    @property
    def params(self) -> tuple[Param, ...]:
        return weights_of_waves(self.size, self.highest, self.motions)

    @property
    def of_base(self) -> bool:
        return self.variant.startswith("base")

    @property
    def like(self) -> str:
        what = "base (or an instrument)" if self.of_base else "tool"
        return f"a {what} that moves in the course of the campaign"

    def x(self, problem: Problem) -> Array:
        if self.variant.endswith("time") and problem.time is not None:
            return np.asarray(problem.time)
        return np.arange(len(problem.q), dtype=float)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        return each(self._columns(problem), waves_over(self.x(problem), self.highest))

    def _columns(self, problem: Problem) -> Sequence[int]:
        return base_or_flange(problem, self.of_base)

    @classmethod
    def of(cls, problem: Problem) -> Sequence[Clock]:
        """Of base and tool, by what was recorded."""
        return [
            cls(variant=f"{which} in {recorded(problem)}", highest=highest)
            for highest in waves_shown(problem)
            for which in ("base", "tool")
        ]

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Clock]:
        return [] if problem.time_passes else cls.of(problem)


@dataclass(frozen=True)
class Creeping(Clock):
    """Base or tool creeps to rest in the order of measurement, where no time was recorded, as what warms up
    does: fast at first, which no few waves are. constant: in poses."""

    variant: str = "base creeping"
    highest: float = 1.0
    constant: float = 1.0

    settings: ClassVar[tuple[str, ...]] = (*Clock.settings, "constant")

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        return each(self._columns(problem), share_gone(self.x(problem), self.constant)[:, None])

    @classmethod
    def of(cls, problem: Problem) -> Sequence[Clock]:
        return [
            cls(variant=f"{which} creeping", constant=share * len(problem.q))
            for share in (SOONEST, *SHARES)
            for which in ("base", "tool")
        ]


@dataclass(frozen=True)
class ZeroInTime(Clock):
    """The zero of one joint moves with time, or where none was recorded with the order of measurement: in
    steps, say, as a coupling that slips."""

    variant: str = "zero in time"
    size: float = 5e-5

    lacks: ClassVar[str] = ""

    @property
    def motions(self) -> int:
        return 1

    @property
    def variable(self) -> str:
        return f"{super().variable} (the zero of {self.where.joint} moves)"

    @property
    def like(self) -> str:
        return f"a zero of {self.where.joint} that moves in the course of the campaign"

    def _columns(self, problem: Problem) -> Sequence[int]:
        return [int(problem.arm.axial[problem.joint(self.where.joint)])]

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Clock]:
        variant = f"zero in {recorded(problem)}"
        return [
            cls(Where(joint=problem.arm.names[j]), variant, highest=highest)
            for highest in waves_shown(problem)
            for j in moving(problem)
        ]


def recorded(problem: Problem) -> str:
    """What tells when a pose was measured."""
    return "time" if problem.time_passes else "order"


def waves_over(x: Array, highest: float) -> Array:
    """(N, highest) cosines over the range of x (N,), of half a wave and its multiples."""
    share = (x - x.min()) / max(float(np.ptp(x)), 1e-12)
    return np.asarray(np.cos(np.pi * np.outer(share, np.arange(1, int(highest) + 1))))


def weights_of_waves(size: float, highest: float, motions: int) -> tuple[Param, ...]:
    """Weights of such waves, of each motion by itself, together as large as a size [rad, m]; sharp ones are
    smaller, as those of a random walk."""
    slower = np.tile(1 / np.arange(1, int(highest) + 1), motions)
    each = size * slower / np.linalg.norm(slower)
    return tuple(Param(f"weight_{k}", "rad", s, spread=s) for k, s in enumerate(map(float, each), 1))


def waves_shown(problem: Problem) -> list[float]:
    """Number of waves that a campaign can show; nothing where it can show none."""
    visits = 1 + int(np.count_nonzero(np.diff(problem.positions)))
    highest = min(visits // VISITS_PER_WAVE, WAVES_IN_TIME)
    return [float(highest)] if highest else []


@dataclass(frozen=True)
class Along(Unnamed, DirectEffect):
    """The base moves along with a joint that went one way through the campaign: what looks like a drift in
    time may be of the joint. motions: 3, it shifts, or 6, and turns."""

    variant: str = "along"
    size: float = 3e-5
    motions: float = 6.0

    depends: ClassVar[Depends] = frozenset({"joints"})
    settings: ClassVar[tuple[str, ...]] = ("size", "motions")

    @property
    def functions(self) -> int:
        return int(self.motions)

    @property
    def variable(self) -> str:
        return f"{self.where.joint} (the base shifts{' and turns' if self.functions > 3 else ''})"

    def x(self, problem: Problem) -> Array:
        return np.asarray(problem.q[:, problem.joint(self.where.joint)])

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        x = self.x(problem) - self.x(problem).mean()
        return each(range(self.functions), x[:, None] / max(float(np.abs(x).max()), 1e-12))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Along]:
        if not problem.time_passes:
            return []
        time = since_start(problem, 0.0)
        return [
            cls(Where(joint=problem.arm.names[j]), motions=motions)
            for j in moving(problem)
            if abs(np.corrcoef(time, problem.q[:, j])[0, 1]) > WITH_TIME
            for motions in (3.0, 6.0)
        ]


@dataclass(frozen=True)
class Zeros(Unnamed, DirectEffect):
    """The zeros of all turning joints move with time, evenly (`constant` 0) or creeping to rest with a time
    constant [s], as drives do that warm up: what looks much like a base that drifts. start: the campaign's
    first instant [s], motions: so many joints."""

    variant: str = "zeros"
    size: float = 5e-5
    start: float = 0.0
    constant: float = 0.0
    motions: float = 6.0

    depends: ClassVar[Depends] = frozenset({"time"})
    settings: ClassVar[tuple[str, ...]] = ("size", "start", "constant", "motions")
    variable: ClassVar[str] = "time (the joints' zeros move)"
    unit: ClassVar[str] = "s"

    @property
    def functions(self) -> int:
        return int(self.motions)

    @property
    def like(self) -> str:
        return "zeros of joints that move in the course of the campaign, as they do while drives warm up"

    def x(self, problem: Problem) -> Array:
        return since_start(problem, self.start)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        way = gone(self.x(problem), self.constant)
        return each(_turning(problem), way[:, None] / max(float(way.max()), 1e-12))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Zeros]:
        turning = float(len(_turning(problem)))
        if not problem.time_passes or not turning:
            return []
        start, span = start_and_span(problem)
        constants = (0.0, *(share * span for share in SHARES))
        return [cls(start=start, constant=constant, motions=turning) for constant in constants]


@dataclass(frozen=True)
class Warmth(Unnamed, DirectEffect):
    """The base moves with temperature."""

    variant: str = "temperature"
    size: float = 3e-5

    depends: ClassVar[Depends] = frozenset({"temperature"})
    functions: ClassVar[int] = 6
    variable: ClassVar[str] = "temperature"
    unit: ClassVar[str] = "K"

    def x(self, problem: Problem) -> Array:
        return np.zeros(len(problem.q)) if problem.warmth is None else np.asarray(problem.warmth)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        x = self.x(problem) - self.x(problem).mean()
        return each(range(6), x[:, None] / max(float(np.abs(x).max()), 1e-12))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        return [] if problem.warmth is None or np.ptp(problem.warmth) == 0 else [cls()]


@dataclass(frozen=True)
class PerPayload(Unnamed, DirectEffect):
    """The tool sits otherwise on the flange with every payload."""

    variant: str = "payload"
    size: float = 3e-5
    others: float = 1.0

    depends: ClassVar[Depends] = frozenset({"payload"})
    by_loads: ClassVar[bool] = True
    settings: ClassVar[tuple[str, ...]] = ("size", "others")
    variable: ClassVar[str] = "payload"
    unit: ClassVar[str] = "1"

    @property
    def functions(self) -> int:
        return 6 * int(self.others)

    def x(self, problem: Problem) -> Array:
        return problem.campaign.poses.payload.astype(float)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        which = np.arange(1, 1 + int(self.others))
        return each(flange_of(problem), (self.x(problem)[:, None] == which).astype(float))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        """Of all payloads that the campaign knows, so that it is the same at poses with others of them."""
        known, carried = problem.campaign.payload_names, problem.campaign.poses.payload
        return [cls(others=len(known) - 1.0)] if np.ptp(carried) > 0 else []


@dataclass(frozen=True)
class Attitude(Unnamed, DirectEffect):
    """The tool moves on the flange by the way that the hand points."""

    variant: str = "attitude"

    depends: ClassVar[Depends] = frozenset({"joints"})
    by_loads: ClassVar[bool] = True
    functions: ClassVar[int] = 54
    variable: ClassVar[str] = "attitude of the hand"
    unit: ClassVar[str] = "1"

    def x(self, problem: Problem) -> Array:
        return np.asarray(problem.rigid.R[-1][:, 2, 2])

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        R = problem.rigid.R[-1]
        way = np.column_stack([R[:, :, 2], R[:, :, 0], np.tanh(8 * R[:, :, 2])])
        return each(flange_of(problem), way)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        return [cls()]


def _turning(problem: Problem) -> list[int]:
    """Columns of the joints that turn."""
    return [int(column) for column in problem.arm.axial[~problem.arm.prismatic]]


def flange_of(problem: Problem) -> range:
    """Columns of the flange's motions."""
    first = 6 * (problem.arm.n + 1)
    return range(first, first + 6)


def base_or_flange(problem: Problem, base: bool) -> range:
    """Columns of the base's motions, or of the flange's."""
    return range(6) if base else flange_of(problem)
