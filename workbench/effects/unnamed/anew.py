"""What stands elsewhere in each of several campaigns that are fitted as one robot: it was mastered anew, hit
something, was repaired, or is another specimen.

Both are zero in the last of the campaigns: a model that leaves them out is the robot as that found it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..base import Depends, motion_said
from ..kinds import DirectEffect
from ..place import Where
from .base import Unnamed, each, moving

MOST = 4  # further set-ups that may each have a geometry of its own: more of them have too few poses


@dataclass(frozen=True)
class Anew(Unnamed, DirectEffect):
    """One place of the robot for each set-up but the last. others: number of these."""

    size: float = 3e-4
    others: float = 1.0

    depends: ClassVar[Depends] = frozenset({"setup"})
    settings: ClassVar[tuple[str, ...]] = ("size", "others")
    dated: ClassVar[bool] = True

    @property
    def unit(self) -> str:
        return "1"

    def x(self, problem: Problem) -> Array:
        return problem.campaign.poses.setup.astype(float)

    def _before_last(self, problem: Problem) -> Array:
        """(N, others) 1 in the poses of each set-up but the last."""
        return (problem.campaign.poses.setup[:, None] == np.arange(int(self.others))).astype(float)


@dataclass(frozen=True)
class ZeroAnew(Anew):
    """A joint's zero stands elsewhere in each campaign: it was mastered anew."""

    variant: str = "zero anew"

    @property
    def functions(self) -> int:
        return int(self.others)

    @property
    def variable(self) -> str:
        return f"the campaign: the zero of {self.where.joint} is not the same in all"

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        column = int(problem.arm.axial[problem.joint(self.where.joint)])
        return {column: self._before_last(problem)}

    def as_commanded(self, problem: Problem, values: Array) -> Array:
        q = problem.q.copy()
        q[:, problem.joint(self.where.joint)] += self._before_last(problem) @ values
        return q

    def said_by_setup(self, problem: Problem, values: Array, std: Array) -> Sequence[tuple[int, str]]:
        j, names = problem.joint(self.where.joint), problem.campaign.setup_names

        def said(k: int, value: float, spread: float) -> str:
            size, error = (motion_said(v, bool(problem.arm.prismatic[j])) for v in (value, spread))
            size = size.replace("-", "\N{MINUS SIGN}")
            where = f"the zero of {self.where.joint} in {names[k]}"
            return f"{where} is {size} (± {error}) from that in {names[-1]}"

        each = enumerate(zip(values.tolist(), std.tolist(), strict=True))
        return [(k, said(k, *one)) for k, one in each]

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        others, names = _others(problem), problem.arm.names
        return [cls(Where(joint=names[j]), others=others) for j in moving(problem)] if others else []


@dataclass(frozen=True)
class GeometryAnew(Anew):
    """Every campaign has a geometry of its own: it is another robot, or one that was taken apart. motions:
    those of all its joints' frames."""

    variant: str = "geometry anew"
    motions: float = 36.0

    settings: ClassVar[tuple[str, ...]] = ("size", "others", "motions")

    @property
    def functions(self) -> int:
        return int(self.others * self.motions)

    @property
    def variable(self) -> str:
        return "the campaign: the geometry of the robot is not the same in all"

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        return each(range(6, 6 + int(self.motions)), self._before_last(problem))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        others = _others(problem)
        return [cls(others=others, motions=6.0 * problem.arm.n)] if 0 < others <= MOST else []


def _others(problem: Problem) -> float:
    """Number of set-ups but the last; 0 of a single campaign, whose robot stays what it is."""
    campaign = problem.campaign
    return float(len(campaign.setup_names) - 1) if campaign.beside else 0.0
