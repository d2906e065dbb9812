"""Functions without a name: what a robot does that no cause of the catalogue explains.

They compete with the causes (Kennedy & O'Hagan 2001: a discrepancy belongs into the fit), say what the rest
depends on, and correct it. Each is a form (`variant`) of the one cause `unknown`.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import RX, Arm, Array
from .base import UNKNOWN, Depends, Effect, Param, Rest
from .drawn import Drawn
from .kinds import AxialYield, DirectEffect, InstrumentEffect, TransmissionEffect, YieldEffect
from .place import Where

MOVES = 1e-3  # rad or m: a joint that moves less than this shows no function of itself
SLIDES = 3.0  # rad per metre: a sliding joint's travel as an angle


@dataclass(frozen=True)
class Unnamed(Effect):
    """A function with Gaussian weights: `size` [rad, m] is the usual size of what it moves."""

    size: float = 1e-4

    cause: ClassVar[str] = UNKNOWN
    title: ClassVar[str] = "Something that no cause of the catalogue explains"
    settings: ClassVar[tuple[str, ...]] = ("size",)

    @property
    @abstractmethod
    def functions(self) -> int:
        """Number of its functions."""

    @property
    @abstractmethod
    def variable(self) -> str:
        """What it is a function of, for people."""

    @property
    def unit(self) -> str:
        """Unit of the variable."""
        return "rad"

    @abstractmethod
    def x(self, problem: Problem) -> Array:
        """(N,) the variable."""

    @property
    def params(self) -> tuple[Param, ...]:
        each = self.size / np.sqrt(self.functions)
        return tuple(Param(f"weight_{k}", "rad", each, spread=each) for k in range(1, self.functions + 1))

    @property
    def lasting(self) -> bool:
        return self.uses <= {"joints", "load"}

    @property
    def label(self) -> str:
        return f"a dependence on {self.variable}"

    def sized(self, scale: float) -> Effect:
        return replace(self, size=scale * self.size)

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """Over its variable, each pose as large as the function's part there."""
        moved = sum((basis @ values) ** 2 for basis in self.motion(problem).values())
        size = np.sqrt(moved) if np.ndim(moved) else np.zeros(len(problem.q))
        return Drawn(self.x(problem), self.variable, self.unit, size, "size", "rad")


@dataclass(frozen=True)
class Pair(Unnamed, TransmissionEffect):
    """A joint's error by another joint's angle, and by both."""

    variant: str = "pair"
    own: float = 1.0
    other: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "own", "other")

    @property
    def functions(self) -> int:
        return 7

    @property
    def variable(self) -> str:
        return f"{self.where.joint} with {self.where.other}"

    def x(self, problem: Problem) -> Array:
        return np.asarray(problem.q[:, problem.joint(self.where.other)])

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        a = self.own * q[:, joints.index(str(self.where.joint))]
        b = self.other * q[:, joints.index(str(self.where.other))]
        sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
        return np.column_stack([b / np.pi, sb, cb, sa * sb, sa * cb, ca * sb, ca * cb])

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        names, turn, moved = problem.arm.names, _turn(problem), _moved(problem)
        return [
            cls(Where(joint=names[i], other=names[j]), own=turn[i], other=turn[j])
            for i in moved for j in moved if i != j
        ]  # fmt: skip


@dataclass(frozen=True)
class Product(Unnamed, TransmissionEffect):
    """A joint's error by products of waves of two other joints: for a joint that scatters."""

    variant: str = "product"
    third: float = 0.0

    settings: ClassVar[tuple[str, ...]] = ("size", "third")

    @property
    def functions(self) -> int:
        return 36

    @property
    def variable(self) -> str:
        return f"{self.where.joint} with {self.where.other} and joint {self.third + 1:g}"

    def x(self, problem: Problem) -> Array:
        return np.asarray(problem.q[:, problem.joint(self.where.other)])

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        a, b = _waves(q[:, joints.index(str(self.where.other))], 3), _waves(q[:, int(self.third)], 3)
        return np.asarray((a[:, :, None] * b[:, None, :]).reshape(len(q), -1))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        arm = problem.arm
        turning = [j for j in _moved(problem) if not arm.prismatic[j]]
        return [
            cls(Where(joint=arm.names[i], other=arm.names[j]), third=float(k))
            for i in range(arm.n) for j in turning for k in turning if i != j < k != i
        ]  # fmt: skip


@dataclass(frozen=True)
class Tilt(Unnamed, DirectEffect):
    """A joint's frame tilts across its axis with its own angle."""

    variant: str = "tilt"
    size: float = 5e-5

    depends: ClassVar[Depends] = frozenset({"joints"})

    @property
    def functions(self) -> int:
        return 8

    @property
    def variable(self) -> str:
        return f"{self.where.joint} (tilt)"

    def x(self, problem: Problem) -> Array:
        return np.asarray(problem.q[:, problem.joint(self.where.joint)])

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        j = problem.joint(self.where.joint)
        first = 6 * (j + 1) + RX
        return _each((first, first + 1), _waves(_turn(problem)[j] * problem.q[:, j], 2))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        return [cls(Where(joint=problem.arm.names[j])) for j in _moved(problem)]


@dataclass(frozen=True)
class Torque(Unnamed, AxialYield):
    """A joint's error by its torque, even: what is odd in it is a compliance. largest [N·m, N]: torque of
    the campaign."""

    variant: str = "torque"
    largest: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "largest")

    @property
    def functions(self) -> int:
        return 2

    @property
    def variable(self) -> str:
        return f"torque of {self.where.joint}"

    @property
    def unit(self) -> str:
        return "N·m"

    def x(self, problem: Problem) -> Array:
        return _own_load(problem, problem.joint(self.where.joint))

    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        (axial,) = self.components(arm)
        x = wrench[:, axial] / self.largest
        unit, by_wrench = np.zeros((len(wrench), 6, 2)), np.zeros((len(wrench), 6, 6))
        unit[:, axial] = np.column_stack([x**2, np.abs(x)])
        by_wrench[:, axial, axial] = (2 * x * values[0] + np.sign(x) * values[1]) / self.largest
        return unit @ values, by_wrench, unit

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        out = []
        for j, name in enumerate(problem.arm.names):
            load = _own_load(problem, j)
            most = float(np.abs(load).max(initial=0.0))
            if np.ptp(load) > 1e-3 * max(most, 1.0):
                out.append(cls(Where(joint=name), largest=most))
        return out


@dataclass(frozen=True)
class Load(Unnamed, YieldEffect):
    """A joint's frame shifts and turns with every force and moment on it. force [N], moment [N·m]: the
    largest of the campaign. A shift's usual size is that of a turn at 0.3 m."""

    variant: str = "load"
    size: float = 5e-5
    force: float = 1.0
    moment: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "force", "moment")

    @property
    def functions(self) -> int:
        return 36

    @property
    def variable(self) -> str:
        return f"load on {self.where.joint}"

    @property
    def unit(self) -> str:
        return "N·m"

    def x(self, problem: Problem) -> Array:
        return np.linalg.norm(problem.nominal_load.local[:, self.slot(problem.arm), RX:], axis=1)

    def slot(self, arm: Arm) -> int:
        return arm.names.index(str(self.where.joint)) + 1

    def components(self, arm: Arm) -> tuple[int, ...]:
        return tuple(range(6))

    def law(self, arm: Arm, wrench: Array, values: Array) -> tuple[Array, Array, Array]:
        reach = np.array([0.3, 0.3, 0.3, 1.0, 1.0, 1.0])
        per = 1 / np.array([self.force] * 3 + [self.moment] * 3)
        C = reach[:, None] * values.reshape(6, 6) * per
        unit = np.einsum("ik,nj->nikj", np.diag(reach), wrench * per).reshape(len(wrench), 6, 36)
        return wrench @ C.T, np.broadcast_to(C, (len(wrench), 6, 6)), unit

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        out = []
        for j, name in enumerate(problem.arm.names):
            load = np.abs(problem.nominal_load.local[:, j + 1]).max(axis=0, initial=0.0)
            force, moment = float(load[:RX].max()), float(load[RX:].max())
            if min(force, moment) > 1e-3:
                out.append(cls(Where(joint=name), force=force, moment=moment))
        return out


@dataclass(frozen=True)
class Side(Unnamed, TransmissionEffect):
    """A joint's error by its side of approach and its angle."""

    variant: str = "side"

    depends: ClassVar[Depends] = frozenset({"joints", "side"})

    @property
    def functions(self) -> int:
        return 3

    @property
    def variable(self) -> str:
        return f"approach of {self.where.joint}"

    @property
    def unit(self) -> str:
        return "1"

    def x(self, problem: Problem) -> Array:
        side = problem.campaign.poses.side
        return np.zeros(len(problem.q)) if side is None else side[:, problem.joint(self.where.joint)]

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        j = joints.index(str(self.where.joint))
        side = np.zeros(len(q)) if direction is None else direction[:, j]
        return np.column_stack([side, side * np.sin(q[:, j]), side * np.cos(q[:, j])])

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        side = problem.campaign.poses.side
        if side is None:
            return []
        return [cls(Where(joint=n)) for j, n in enumerate(problem.arm.names) if np.ptp(side[:, j]) > 0]


@dataclass(frozen=True)
class Clock(Unnamed, DirectEffect):
    """Base or tool (`variant`) moves with time, or where none was recorded with the order of measurement."""

    variant: str = "base"
    size: float = 3e-5

    depends: ClassVar[Depends] = frozenset({"time"})

    @property
    def functions(self) -> int:
        return 6 * WAVES_IN_TIME

    @property
    def variable(self) -> str:
        return "time" if self.variant.endswith("time") else "order of measurement"

    @property
    def unit(self) -> str:
        return "s" if self.variant.endswith("time") else "1"

    @property
    def params(self) -> tuple[Param, ...]:
        slower = np.tile(np.arange(1, WAVES_IN_TIME + 1) ** -1.5, 6)
        each = self.size * slower / np.linalg.norm(slower)
        return tuple(Param(f"weight_{k}", "rad", s, spread=s) for k, s in enumerate(map(float, each), 1))

    def x(self, problem: Problem) -> Array:
        if self.variant.endswith("time") and problem.time is not None:
            return np.asarray(problem.time)
        return np.arange(len(problem.q), dtype=float)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        x = self.x(problem)
        share = (x - x.min()) / max(float(np.ptp(x)), 1e-12)
        waves = np.cos(np.pi * np.outer(share, np.arange(1, WAVES_IN_TIME + 1)))
        first = 0 if self.variant.startswith("base") else 6 * (problem.arm.n + 1)
        return _each(range(first, first + 6), waves)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        timed = problem.time is not None and np.ptp(problem.time) > 0
        return [cls(variant=f"{which} in {'time' if timed else 'order'}") for which in ("base", "tool")]


@dataclass(frozen=True)
class Warmth(Unnamed, DirectEffect):
    """The base moves with temperature."""

    variant: str = "temperature"
    size: float = 3e-5

    depends: ClassVar[Depends] = frozenset({"temperature"})

    @property
    def functions(self) -> int:
        return 6

    @property
    def variable(self) -> str:
        return "temperature"

    @property
    def unit(self) -> str:
        return "K"

    def x(self, problem: Problem) -> Array:
        return np.zeros(len(problem.q)) if problem.warmth is None else np.asarray(problem.warmth)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        x = self.x(problem) - self.x(problem).mean()
        return _each(range(6), x[:, None] / max(float(np.abs(x).max()), 1e-12))

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
    settings: ClassVar[tuple[str, ...]] = ("size", "others")

    @property
    def functions(self) -> int:
        return 6 * int(self.others)

    @property
    def variable(self) -> str:
        return "payload"

    @property
    def unit(self) -> str:
        return "1"

    def x(self, problem: Problem) -> Array:
        return problem.campaign.poses.payload.astype(float)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        carried = problem.campaign.poses.payload
        present = np.unique(carried)[1:]
        return _each(_flange(problem), (carried[:, None] == present).astype(float))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        others = len(np.unique(problem.campaign.poses.payload)) - 1
        return [cls(others=float(others))] if others > 0 else []


@dataclass(frozen=True)
class Attitude(Unnamed, DirectEffect):
    """The tool moves on the flange by the way that the hand points."""

    variant: str = "attitude"

    depends: ClassVar[Depends] = frozenset({"joints"})

    @property
    def functions(self) -> int:
        return 54

    @property
    def variable(self) -> str:
        return "attitude of the hand"

    @property
    def unit(self) -> str:
        return "1"

    def x(self, problem: Problem) -> Array:
        return np.asarray(problem.rigid.R[-1][:, 2, 2])

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        R = problem.rigid.R[-1]
        way = np.column_stack([R[:, :, 2], R[:, :, 0], np.tanh(8 * R[:, :, 2])])
        return _each(_flange(problem), way)

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        return [cls()]


@dataclass(frozen=True)
class Bearing(Unnamed, InstrumentEffect):
    """The instrument turns about its vertical by the bearing."""

    variant: str = "bearing"

    @property
    def functions(self) -> int:
        return 10

    @property
    def variable(self) -> str:
        return "bearing from the instrument"

    def x(self, problem: Problem) -> Array:
        return _bearing(problem.campaign.points)

    def seen(self, problem: Problem, points: Array) -> Array:
        turn = np.stack([-points[..., 1], points[..., 0], np.zeros_like(points[..., 0])], axis=-1)
        waves = _waves(_bearing(points), 5)
        return np.asarray(turn[..., None] * waves[:, None, None, :])

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        return [cls()] if np.ptp(_bearing(problem.campaign.points)) > MOVES else []


WAVES_IN_TIME = 6
KINDS: tuple[type[Unnamed], ...] = (
    Tilt, Pair, Torque, Load, Side, Clock, Warmth, PerPayload, Attitude, Bearing, Product,
)  # fmt: skip


def unnamed(problem: Problem) -> Iterator[Unnamed]:
    """Every function without a name that a campaign allows, but products: see `products`."""
    for kind in KINDS:
        if kind is not Product:
            yield from kind.sites(problem)  # type: ignore[misc]


def kind_of(variant: str) -> type[Unnamed] | None:
    """The kind of function that a variant is a form of."""
    return next((kind for kind in KINDS if kind.variant == variant), None)


def products(problem: Problem, joint: int) -> Iterator[Unnamed]:
    """Functions of two other joints, of one joint's error."""
    name = problem.arm.names[joint]
    yield from (one for one in Product.sites(problem) if one.where.joint == name)


def _moved(problem: Problem) -> list[int]:
    return [j for j in range(problem.arm.n) if np.ptp(problem.q[:, j]) > MOVES]


def _turn(problem: Problem) -> list[float]:
    return [SLIDES if sliding else 1.0 for sliding in problem.arm.prismatic]


def _flange(problem: Problem) -> range:
    first = 6 * (problem.arm.n + 1)
    return range(first, first + 6)


def _own_load(problem: Problem, j: int) -> Array:
    """(N,) torque or force of a joint of the stated robot."""
    load = problem.nominal_load.local
    return np.asarray(load.reshape(len(load), -1)[:, problem.arm.axial[j]])


def _waves(angle: Array, highest: int) -> Array:
    """(N, 2 highest) sines and cosines of an angle (N,) and its multiples."""
    return np.column_stack([f(k * angle) for k in range(1, highest + 1) for f in (np.sin, np.cos)])


def _each(columns: Sequence[int], functions: Array) -> dict[int, Array]:
    """Every column moved by every function (N, f): column → (N, columns · f)."""
    n, f = functions.shape
    out = {}
    for i, column in enumerate(columns):
        basis = np.zeros((n, len(columns) * f))
        basis[:, i * f : (i + 1) * f] = functions
        out[column] = basis
    return out


def _bearing(points: Array) -> Array:
    """(N,) direction [rad] in which the points (N, T, 3) of a pose stand."""
    seen = np.asarray(np.isfinite(points).all(axis=2))
    count = np.maximum(seen.sum(axis=1), 1)[:, None]
    middle = np.where(seen[..., None], points, 0.0).sum(axis=1) / count
    return np.asarray(np.arctan2(middle[:, 1], middle[:, 0]))
