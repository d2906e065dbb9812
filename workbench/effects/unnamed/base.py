"""What functions without a name have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..base import UNKNOWN, Effect, Param, Rest
from ..drawn import Drawn
from ..place import Parameter

MOVES = 1e-3  # rad or m: a joint that moves less than this shows no function of itself
SLIDES = 3.0  # rad per metre: a sliding joint's travel as an angle


@dataclass(frozen=True)
class Unnamed(Effect):
    """A function with Gaussian weights: `size` [rad, m] is the usual size of what it moves."""

    size: float = 1e-4

    cause: ClassVar[str] = UNKNOWN
    title: ClassVar[str] = "Something that no cause of the catalogue explains"
    settings: ClassVar[tuple[str, ...]] = ("size",)
    lacks: ClassVar[str] = ""  # what to state, or to do, so that it may get a name

    @property
    @abstractmethod
    def functions(self) -> int:
        """Number of its functions."""

    @property
    @abstractmethod
    def variable(self) -> str:
        """What it is a function of, for people."""

    def found(self, values: Array) -> str:
        """The same, with what was found of it."""
        return self.variable

    @property
    def like(self) -> str:
        """What it looks like, for people; nothing where that is not known."""
        return ""

    @property
    def unit(self) -> str:
        """Unit of the variable."""
        return "rad"

    @abstractmethod
    def x(self, problem: Problem) -> Array:
        """(N,) the variable."""

    @cached_property
    def params(self) -> tuple[Param, ...]:
        each = self.size / np.sqrt(self.functions)
        return tuple(Param(f"weight_{k}", "rad", each, spread=each) for k in range(1, self.functions + 1))

    @property
    def lasting(self) -> bool:
        return self.uses <= {"joints", "load"}

    @property
    def label(self) -> str:
        return f"a dependence on {self.variable}"

    def report(self, values: Array, covariance: Array) -> tuple[Parameter, ...]:
        """How large it is: its weights are nobody's numbers."""
        size = float(np.linalg.norm(values))
        std = float(np.sqrt(values @ covariance @ values)) / size if size > 0 else 0.0
        return (Parameter("size", size, std, "rad", "RMS of what is beside that form", least=0.0),)

    def sized(self, scale: float) -> Effect:
        return replace(self, size=scale * self.size)

    def drawn(self, problem: Problem, rest: Rest, values: Array) -> Drawn:
        """Over its variable, each pose as large as the function's part there."""
        moved = sum((basis @ values) ** 2 for basis in self.motion(problem).values())
        size = np.sqrt(moved) if np.ndim(moved) else np.zeros(len(problem.q))
        return Drawn(self.x(problem), self.variable, self.unit, size, "size", "rad")


def moving(problem: Problem) -> list[int]:
    """Numbers of the joints that move."""
    return [j for j in range(problem.arm.n) if np.ptp(problem.q[:, j]) > MOVES]


def turn(problem: Problem) -> list[float]:
    """What makes an angle of each joint's position."""
    return [SLIDES if sliding else 1.0 for sliding in problem.arm.prismatic]


def waves(angle: Array, highest: int) -> Array:
    """(N, 2 highest) sines and cosines of an angle (N,) and its multiples."""
    return np.column_stack([f(k * angle) for k in range(1, highest + 1) for f in (np.sin, np.cos)])


def each(columns: Sequence[int], functions: Array) -> dict[int, Array]:
    """Every column moved by every function (N, f): column → (N, columns · f)."""
    n, f = functions.shape
    out = {}
    for i, column in enumerate(columns):
        basis = np.zeros((n, len(columns) * f))
        basis[:, i * f : (i + 1) * f] = functions
        out[column] = basis
    return out
