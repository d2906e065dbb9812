"""A step: from one pose on base, instrument, tool or a joint's zero stand otherwise."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..base import Depends, Effect, motion_said
from ..kinds import DirectEffect
from ..place import Where
from ..recorded import DataFault
from .base import Unnamed, each, moving
from .campaign import base_or_flange

Index = NDArray[np.int64]


@dataclass(frozen=True)
class Stepping(Unnamed, DirectEffect):
    """Some motions are others from pose number `first` on, to the end of its stretch. A search says where;
    pose: its name in the campaign."""

    size: float = 3e-5
    first: float = 0.0
    pose: str = ""

    depends: ClassVar[Depends] = frozenset({"time"})
    settings: ClassVar[tuple[str, ...]] = ("size", "first")
    unit: ClassVar[str] = "1"

    def x(self, problem: Problem) -> Array:
        return np.arange(len(problem.q), dtype=float)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        return each(self.columns(problem), self.after(problem))

    def after(self, problem: Problem) -> Array:
        """(N, 1) 1 in the poses after it, 0 in others."""
        after = np.zeros((len(problem.q), 1))
        (own,) = (own for own in self.stretches(problem) if int(self.first) in own)
        after[own[own >= self.first]] = 1.0
        return after

    def stretches(self, problem: Problem) -> Sequence[Index]:
        """Numbers of the poses (K,) of each stretch, at the end of which a step ends: the campaign."""
        return [np.arange(len(problem.q))]

    @abstractmethod
    def columns(self, problem: Problem) -> Sequence[int]:
        """The motions that step."""

    @classmethod
    @abstractmethod
    def sites(cls, problem: Problem) -> Sequence[Self]:
        """Each after the first half of the poses: where it is a search shows."""


@dataclass(frozen=True)
class AtOnce(Stepping):
    """Base (or instrument) or tool slipped, or was moved: it stands otherwise to the end of its set-up."""

    variant: str = "base at once"

    functions: ClassVar[int] = 6

    @property
    def of_tool(self) -> bool:
        return self.variant.startswith("tool")

    @property
    def kind(self) -> DataFault:
        """What it is of a campaign."""
        return "changed_setup" if self.of_tool else "moved_instrument"

    @property
    def label(self) -> str:
        return f"a step of the {'tool' if self.of_tool else 'base or the instrument'}"

    @property
    def variable(self) -> str:
        return f"the order of measurement ({self.label} before pose {self.pose})"

    @property
    def like(self) -> str:
        return f"{self.label} in the course of the campaign"

    def columns(self, problem: Problem) -> Sequence[int]:
        return base_or_flange(problem, not self.of_tool)

    def stretches(self, problem: Problem) -> Sequence[Index]:
        return problem.campaign.poses.by_setup

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Self]:
        middle = float(len(problem.q) // 2)
        return [cls(variant=f"{which} at once", first=middle) for which in ("base", "tool")]


@dataclass(frozen=True)
class ZeroAtOnce(Stepping):
    """The zero of one joint is another: a coupling, a belt or an encoder slipped, or it was set anew."""

    variant: str = "zero at once"
    size: float = 5e-5

    functions: ClassVar[int] = 1

    @property
    def label(self) -> str:
        return f"a step of the zero of {self.where.joint}"

    @property
    def variable(self) -> str:
        return self._said("steps")

    def found(self, values: Array) -> str:
        return self._said(f"steps by {motion_said(abs(float(values[0])))}")

    def _said(self, steps: str) -> str:
        return f"the order of measurement (the zero of {self.where.joint} {steps} before pose {self.pose})"

    @property
    def like(self) -> str:
        return f"{self.label} before pose {self.pose}, as where a coupling or an encoder slips"

    def columns(self, problem: Problem) -> Sequence[int]:
        return [int(problem.arm.axial[problem.joint(self.where.joint)])]

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Self]:
        if problem.campaign.beside:  # several campaigns: a zero is another in one of them as a whole
            return []
        middle = float(len(problem.q) // 2)
        return [cls(Where(joint=problem.arm.names[j]), first=middle) for j in moving(problem)]


def stands_anew(effect: Effect | None) -> AtOnce | None:
    """An effect, where it is a step of what stands around the arm; else None."""
    return effect if isinstance(effect, AtOnce) else None
