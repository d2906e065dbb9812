"""Errors of a joint by the angles of joints, and by the side that it came from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import RX, Array
from ..base import Depends
from ..kinds import DirectEffect, TransmissionEffect
from ..place import Where
from .base import Unnamed, each, moving, turn, waves


@dataclass(frozen=True)
class Pair(Unnamed, TransmissionEffect):
    """A joint's error by another joint's angle, and by both."""

    variant: str = "pair"
    own: float = 1.0
    other: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "own", "other")
    by_motor: ClassVar[bool] = False
    functions: ClassVar[int] = 7

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
    def sites(cls, problem: Problem) -> Sequence[Pair]:
        names, turns, moved = problem.arm.names, turn(problem), moving(problem)
        return [
            cls(Where(joint=names[i], other=names[j]), own=turns[i], other=turns[j])
            for i in moved for j in moved if i != j
        ]  # fmt: skip


@dataclass(frozen=True)
class Product(Unnamed, TransmissionEffect):
    """A joint's error by products of waves of two other joints: for a joint that scatters. Of a joint that
    turns more than once they are over the turn, or over its whole travel, as of what winds up."""

    variant: str = "product"
    third: float = 0.0
    other_slower: float = 1.0
    third_slower: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "third", "other_slower", "third_slower")
    by_motor: ClassVar[bool] = False
    functions: ClassVar[int] = 36

    @property
    def variable(self) -> str:
        return f"{self.where.joint} with {self.where.other} and axis {self.third + 1:g}"

    def x(self, problem: Problem) -> Array:
        return np.asarray(problem.q[:, problem.joint(self.where.other)])

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        a = waves(self.other_slower * q[:, joints.index(str(self.where.other))], 3)
        b = waves(self.third_slower * q[:, int(self.third)], 3)
        return np.asarray((a[:, :, None] * b[:, None, :]).reshape(len(q), -1))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        arm = problem.arm
        turning = [j for j in moving(problem) if not arm.prismatic[j]]
        slower = [float(np.pi / one) if one > 2 * np.pi else 1.0 for one in np.ptp(problem.q, axis=0)]
        return [
            cls(Where(joint=arm.names[i], other=arm.names[j]), third=float(k), other_slower=a, third_slower=b)
            for i in range(arm.n) for j in turning for k in turning if i != j < k != i
            for a, b in dict.fromkeys([(1.0, 1.0), (slower[j], slower[k])])
        ]  # fmt: skip


@dataclass(frozen=True)
class SideBands(Unnamed, TransmissionEffect):
    """A gear's line is not the same all around the joint's turn: stronger, or ahead, on one side, as where a
    gear runs out. Amplitude or phase that goes once per turn makes lines one cycle per turn below and above
    it, `where.order`, which stand for nothing by themselves."""

    variant: str = "side bands"

    functions: ClassVar[int] = 4

    @property
    def cycles(self) -> float:
        if self.where.order is None:
            raise ValueError("side bands need the order of their line (cycles per joint turn)")
        return self.where.order

    @property
    def variable(self) -> str:
        return f"{self.where.joint} (its line of {self.cycles:g} cycles per turn around the turn)"

    def x(self, problem: Problem) -> Array:
        return np.asarray(problem.q[:, problem.joint(self.where.joint)])

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        angle = q[:, joints.index(str(self.where.joint))]
        return np.column_stack([waves((self.cycles + side) * angle, 1) for side in (-1, 1)])

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        """Beside the lines of an output that turns once per motor turn, where the ratio is known."""
        turning = [joint for joint in problem.robot.joints if joint.kind == "revolute"]
        return [
            cls(Where(joint=joint.name, order=abs(joint.data.gear_ratio)))
            for joint in turning if joint.data.gear_ratio
        ]  # fmt: skip


@dataclass(frozen=True)
class Tilt(Unnamed, DirectEffect):
    """A joint's frame tilts across its axis with its own angle."""

    variant: str = "tilt"
    size: float = 5e-5

    depends: ClassVar[Depends] = frozenset({"joints"})
    functions: ClassVar[int] = 8

    @property
    def variable(self) -> str:
        return f"{self.where.joint} (its axis wobbles)"

    def x(self, problem: Problem) -> Array:
        return np.asarray(problem.q[:, problem.joint(self.where.joint)])

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        j = problem.joint(self.where.joint)
        first = 6 * (j + 1) + RX
        return each((first, first + 1), waves(turn(problem)[j] * problem.q[:, j], 2))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        return [cls(Where(joint=problem.arm.names[j])) for j in moving(problem)]


@dataclass(frozen=True)
class Side(Unnamed, TransmissionEffect):
    """A joint's error by its side of approach, different around its turn. mean: share of what is the same all
    around, 0 or 1. That is a play, whatever it does beside, so nothing else competes with it as that; models
    written before had it in here."""

    variant: str = "side"
    mean: float = 1.0

    settings: ClassVar[tuple[str, ...]] = ("size", "mean")
    depends: ClassVar[Depends] = frozenset({"joints", "side"})
    unit: ClassVar[str] = "1"

    @property
    def functions(self) -> int:
        return 3 if self.mean else 2

    @property
    def variable(self) -> str:
        return f"approach of {self.where.joint}"

    def x(self, problem: Problem) -> Array:
        side = problem.campaign.poses.side
        return np.zeros(len(problem.q)) if side is None else side[:, problem.joint(self.where.joint)]

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        j = joints.index(str(self.where.joint))
        side = np.zeros(len(q)) if direction is None else direction[:, j]
        around = np.column_stack([side * np.sin(q[:, j]), side * np.cos(q[:, j])])
        return np.column_stack([side, around]) if self.mean else around

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        side = problem.campaign.poses.side
        if side is None:
            return []
        names = problem.arm.names
        return [cls(Where(joint=n), mean=0.0) for j, n in enumerate(names) if np.ptp(side[:, j]) > 0]
