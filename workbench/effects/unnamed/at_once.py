"""A step: from one pose on base, instrument or tool stand otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..base import Depends
from ..kinds import DirectEffect
from ..recorded import DataFault
from .base import Unnamed, each
from .campaign import flange_of


@dataclass(frozen=True)
class AtOnce(Unnamed, DirectEffect):
    """Base (or instrument) or tool stands otherwise from pose number `first` on, to the end of a set-up: it
    slipped, or was moved. A search says where; pose: its name in the campaign."""

    variant: str = "base at once"
    size: float = 3e-5
    first: float = 0.0
    pose: str = ""

    depends: ClassVar[Depends] = frozenset({"time"})
    settings: ClassVar[tuple[str, ...]] = ("size", "first")
    functions: ClassVar[int] = 6
    unit: ClassVar[str] = "1"

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

    def x(self, problem: Problem) -> Array:
        return np.arange(len(problem.q), dtype=float)

    def columns(self, problem: Problem) -> range:
        """Of what moves."""
        return flange_of(problem) if self.of_tool else range(6)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        setup = problem.campaign.poses.setup
        after = (self.x(problem) >= self.first) & (setup == setup[int(self.first)])
        return each(self.columns(problem), after[:, None].astype(float))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[AtOnce]:
        """One of each, after the first half of the poses: where it is a search shows."""
        middle = float(len(problem.q) // 2)
        return [cls(variant=f"{which} at once", first=middle) for which in ("base", "tool")]
