"""A link does not bend alike in all directions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.beam import bending_compliance
from ...robot.kinematics import RX, Array
from ..base import Depends
from ..kinds import DirectEffect
from ..place import Where
from .base import Unnamed


@dataclass(frozen=True)
class UnevenBending(Unnamed, DirectEffect):
    """A link's section is no circle: it bends more in one plane through the link than across that, whichever
    planes these are (Euler–Bernoulli; 1/EI is a symmetric tensor across the link). largest [m]: what its end
    is shifted by at EI = 1 N·m², were it alike."""

    variant: str = "uneven bending"
    size: float = 5e-5
    largest: float = 1.0

    depends: ClassVar[Depends] = frozenset({"load"})
    by_loads: ClassVar[bool] = True
    settings: ClassVar[tuple[str, ...]] = ("size", "largest")

    @property
    def functions(self) -> int:
        return 2

    @property
    def variable(self) -> str:
        return f"bending load of {self.where.link}"

    @property
    def unit(self) -> str:
        return "N·m³"

    def x(self, problem: Problem) -> Array:
        shift = self._wrench(problem) @ bending_compliance(self._span(problem))[:RX].T
        return np.asarray(np.linalg.norm(shift, axis=1))

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        span, slot = self._span(problem), self._slot(problem)
        more = [bending_compliance(span, uneven) / self.largest for uneven in _uneven(span)]
        moved = np.stack([self._wrench(problem) @ C.T for C in more], axis=-1)
        return {6 * slot + k: moved[:, k] for k in range(6)}

    def sentence(self, values: Array) -> str:
        size = float(np.linalg.norm(values)) / self.largest
        return f"It does not bend alike in all directions: 1/EI differs by ±{size:.2g} 1/(N·m²)."

    def _slot(self, problem: Problem) -> int:
        return problem.arm.slot_of_link(str(self.where.link)) + 1

    def _span(self, problem: Problem) -> Array:
        return np.asarray(problem.arm.span[self._slot(problem)])

    def _wrench(self, problem: Problem) -> Array:
        """(N, 6) [N, N·m] at the link's end."""
        return np.asarray(problem.nominal_load.local[:, self._slot(problem)])

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[UnevenBending]:
        """Moving links of some length that carry something."""
        arm = problem.arm
        links = [arm.links[k] for k in range(1, arm.n + 1) if np.linalg.norm(arm.span[k + 1]) > 1e-3]
        every = [(one, float(one.x(problem).max(initial=0.0))) for one in (cls(Where(link=x)) for x in links)]
        return [replace(one, largest=most) for one, most in every if most > 1e-3]


def _uneven(span: Array) -> tuple[Array, Array]:
    """Two tensors (3, 3) across a link that turn moments of one plane into more bending, of the other into
    less; the planes of one are at 45° to those of the other."""
    along = span / np.linalg.norm(span)
    first = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    first /= np.linalg.norm(first)
    second = np.cross(along, first)
    crossed = np.outer(first, second)
    return np.outer(first, first) - np.outer(second, second), crossed + crossed.T
