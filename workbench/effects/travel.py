"""Functions of a joint's own position: a Gaussian process over what the joint travels."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .base import Effect
from .unnamed.base import turn

MARGIN = 0.1  # share of the range that the functions go beyond it, where nothing is known
MOVES = 0.2  # rad that a joint must travel for a function of it to be seen
TRAVEL = 1.0  # m, of a sliding joint without bounds, where nothing was measured
SMOOTH, JAGGED = 3.0, 25.0  # over the length: the shortest wave [1/rad, 1/m] of a function
FAINTEST = 0.02  # share of the largest wave below which a wave is left out

Ends = tuple[float, float, float]  # first, span, room of a range [rad, m]


@dataclass(frozen=True)
class OverTravel(Effect):
    """f(q) = Σ a_k cos(π k (q − q₀)/L), a Gaussian process that forgets itself over `length`.

    The waves' prior sizes are the square roots of the process' spectrum (Rasmussen & Williams 2006, 4.2), for
    a function of usual size `size`: of a smooth process, or where it is `jagged` of that of Ornstein and
    Uhlenbeck (Matérn, ν = 1/2), with waves of all lengths, the shorter the smaller. The joint was measured
    from q₀ `first` over L `span` [rad, m], without `room` at both ends; beyond that the function forgets what
    it says as the process does, over `length`: what nobody measured is no error in the mean, and as unsure
    as the function is large.

    around: 1 where a joint turns more than once and the function is the same in every turn,
    f(q) = Σ a_k sin k q + b_k cos k q: all of it was measured.
    """

    first: float = -np.pi
    span: float = 2 * np.pi
    length: float = 0.25
    size: float = 1e-4
    room: float = 0.0
    around: float = 0.0

    settings: ClassVar[tuple[str, ...]] = ("first", "span", "length", "size", "room", "around")
    local: ClassVar[bool] = True

    @cached_property
    def sizes(self) -> Array:
        """(K,) prior size of each wave, from k = 1: a constant is the joint's zero. Around a turn of all
        sines, then of all cosines."""
        first = self.length * (1.0 if self.around else np.pi / self.span)
        shortest = JAGGED if self.jagged else SMOOTH
        squared = (first * np.arange(1, 1 + int(np.ceil(shortest / first)))) ** 2
        power = 1 / (1 + squared) if self.jagged else np.exp(-0.5 * squared)
        power = power[power > FAINTEST**2 * power[0]]
        power = np.tile(power, 2) if self.around else power
        return np.asarray(self.size * np.sqrt(2 * power / power.sum()))

    def over_range(self, ends: Ends) -> Self:
        """The same over a range."""
        first, span, room = ends
        return replace(self, first=first, span=span, room=room)

    @property
    def jagged(self) -> bool:
        """Whether it has short waves as well as long ones."""
        return False

    @property
    def travelled(self) -> float:
        """[rad, m] over how much the joint was measured."""
        return self.span - 2 * self.room

    @property
    def between(self) -> tuple[float, float]:
        """[rad, m] between which positions that was."""
        return self.first + self.room, self.first + self.span - self.room

    @property
    def kin(self) -> Hashable:
        return "own angle", self.where.joint

    def waves(self, q: Array, joints: tuple[str, ...]) -> Array:
        """(N, K) the waves at joints q (N, n)."""
        angle = q[:, joints.index(str(self.where.joint))]
        if self.around:
            each = np.outer(angle, np.arange(1, 1 + len(self.sizes) // 2))
            return np.concatenate([np.sin(each), np.cos(each)], axis=1)
        x = (angle - self.first) / self.span
        waves = np.cos(np.pi * np.outer(np.clip(x, 0.0, 1.0), np.arange(1, 1 + len(self.sizes))))
        return np.asarray(waves * self._kept(q, joints)[:, None])

    def forgotten(self, q: Array, joints: tuple[str, ...]) -> Array:
        """(N,) one sigma of the function, over its size, that the waves do not have at q (N, n)."""
        return np.asarray(np.sqrt(1 - self._kept(q, joints) ** 2))

    def _kept(self, q: Array, joints: tuple[str, ...]) -> Array:
        """(N,) how much the process still has of what was measured, where q (N, n) is beyond."""
        if self.around:
            return np.ones(len(q))
        x = q[:, joints.index(str(self.where.joint))] - self.first
        beyond = x - np.clip(x, self.room, self.span - self.room)
        far = np.abs(beyond) / self.length
        return np.asarray(np.exp(-far) if self.jagged else np.exp(-0.5 * far**2))


def measured(problem: Problem, j: int) -> Ends | None:
    """First, span and room of what a joint travels; None where it hardly moves."""
    low, high = float(problem.q[:, j].min()), float(problem.q[:, j].max())
    if high - low < MOVES / turn(problem)[j]:
        return None
    room = MARGIN * (high - low)
    return low - room, high - low + 2 * room, room


def whole(problem: Problem, j: int) -> Ends:
    """The same of a turn, or all that a joint slides."""
    if not problem.arm.prismatic[j]:
        return -np.pi, 2 * np.pi, 0.0
    low, high = problem.robot.joints[j].lower, problem.robot.joints[j].upper
    if not np.isfinite(high - low):
        low, high = -TRAVEL / 2, TRAVEL / 2
    return low, high - low, 0.0


def rms(waves: Array, covariance: Array) -> tuple[float, float]:
    """RMS over its range of a sum of cosines with amplitudes (K,), (K, K), and its standard deviation."""
    size = float(np.sqrt((waves**2).sum() / 2))
    std = float(np.sqrt(waves @ covariance @ waves)) / (2 * size) if size > 0 else 0.0
    return size, std
