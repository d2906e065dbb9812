"""What a link does at its end beside bending alike in all directions under the loads there: companions of a
link that bends."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.beam import bending_compliance
from ...robot.kinematics import RX, Array
from ...robot.loads import wrenches
from ..base import Depends
from ..kinds import DirectEffect
from ..place import Where
from .base import Unnamed

SHORT = 1e-3  # m, or m at EI = 1 N·m²: what is no more bends nothing


@dataclass(frozen=True)
class OfLink(Unnamed, DirectEffect):
    """Motions of a link's end in 1/EI. largest [m]: what its end is shifted by at EI = 1 N·m²."""

    size: float = 5e-5
    largest: float = 1.0

    depends: ClassVar[Depends] = frozenset({"joints"})
    by_loads: ClassVar[bool] = True
    settings: ClassVar[tuple[str, ...]] = ("size", "largest")
    functions: ClassVar[int] = 1
    unit: ClassVar[str] = "N"

    def slot(self, problem: Problem) -> int:
        """At the link's end."""
        return problem.arm.slot_of_link(str(self.where.link)) + 1

    def span(self, problem: Problem) -> Array:
        """(3,) [m] from the link's root to its end, on the axes of the slot there."""
        return np.asarray(problem.arm.span[self.slot(problem)])

    @abstractmethod
    def usual_shift(self, problem: Problem) -> Array:
        """(N,) [m] what its end is shifted by at EI = 1 N·m²."""

    @abstractmethod
    def moved(self, problem: Problem) -> Array:
        """(N, 6, functions) [m, rad] shift and turn of the end at EI = 1 N·m²."""

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        moved = self.moved(problem) / self.largest
        return {6 * self.slot(problem) + k: moved[:, k] for k in range(6)}

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[OfLink]:
        """Moving links of some length of which the end moves."""
        arm = problem.arm
        links = [arm.links[k] for k in range(1, arm.n + 1) if np.linalg.norm(arm.span[k + 1]) > SHORT]
        every = (cls(Where(link=link)) for link in links)
        sized = [(one, float(one.usual_shift(problem).max(initial=0.0))) for one in every]
        return [replace(one, largest=most) for one, most in sized if most > SHORT]


@dataclass(frozen=True)
class OwnWeight(OfLink):
    """A link's end sags under the weight of the link itself, spread evenly along it: by q l⁴/8, turning by
    q l³/6, over EI, across the link (Euler–Bernoulli)."""

    variant: str = "own weight"

    @property
    def variable(self) -> str:
        return f"weight of {self.where.link} across it"

    def x(self, problem: Problem) -> Array:
        return np.asarray(np.linalg.norm(self.across(problem), axis=1))

    def across(self, problem: Problem) -> Array:
        """(N, 3) [N] the link's weight across it, on the axes of the slot at its end."""
        arm, slot = problem.arm, self.slot(problem)
        axes = problem.rigid.R[slot - 1] @ arm.R[slot]
        weight = arm.mass[slot - 1] * np.einsum("nji,j->ni", axes, arm.gravity)
        along = arm.span[slot] / np.linalg.norm(arm.span[slot])
        return np.asarray(weight - np.outer(weight @ along, along))

    def usual_shift(self, problem: Problem) -> Array:
        return self.x(problem) * float(np.linalg.norm(self.span(problem))) ** 3 / 8

    def moved(self, problem: Problem) -> Array:
        span, weight = self.span(problem), self.across(problem)
        length = float(np.linalg.norm(span))
        shift, turn = weight * length**3 / 8, np.cross(span, weight) * length / 6
        return np.concatenate([shift, turn], axis=1)[:, :, None]


@dataclass(frozen=True)
class PivotForce(OfLink):
    """A link bends by the compensator's force as well, as far as that passes it: what it adds at the link's
    end, by the cantilever's F l³/3 + M l²/2 and F l²/2 + M l over EI; how much of that a casting between
    bracket and bearings bends by nobody knows."""

    variant: str = "pivot force"

    @property
    def variable(self) -> str:
        return f"compensator's force on {self.where.link}"

    def x(self, problem: Problem) -> Array:
        return np.asarray(np.linalg.norm(self.wrench(problem)[:, :RX], axis=1))

    def wrench(self, problem: Problem) -> Array:
        """(N, 6) [N, N·m] what the stated compensator adds at the link's end."""
        without = wrenches(problem.arm, problem.rigid, replace(problem.loads, compensator=None))
        return np.asarray((problem.nominal_load.local - without.local)[:, self.slot(problem)])

    def usual_shift(self, problem: Problem) -> Array:
        return np.asarray(np.linalg.norm(self.moved(problem)[:, :RX, 0], axis=1))

    def moved(self, problem: Problem) -> Array:
        return np.asarray((self.wrench(problem) @ bending_compliance(self.span(problem)).T)[:, :, None])

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[PivotForce]:
        """The link with the compensator's fixed pivot, where it is one that moves and has some length."""
        arm, law = problem.arm, problem.loads.compensator
        if law is None or law.body == 0 or np.linalg.norm(arm.span[law.body + 1]) < SHORT:
            return []
        one = cls(Where(link=arm.links[law.body]))
        return [replace(one, largest=float(one.usual_shift(problem).max(initial=1e-12)))]


@dataclass(frozen=True)
class UnevenBending(OfLink):
    """A link's section is no circle: it bends more in one plane through the link than across that, whichever
    planes these are (Euler–Bernoulli; 1/EI is a symmetric tensor across the link). Its usual shift is that of
    a link that bends alike."""

    variant: str = "uneven bending"

    depends: ClassVar[Depends] = frozenset({"load"})
    functions: ClassVar[int] = 2
    unit: ClassVar[str] = "N·m³"

    @property
    def variable(self) -> str:
        return f"bending load of {self.where.link}"

    def x(self, problem: Problem) -> Array:
        return self.usual_shift(problem)

    def usual_shift(self, problem: Problem) -> Array:
        shift = self._wrench(problem) @ bending_compliance(self.span(problem))[:RX].T
        return np.asarray(np.linalg.norm(shift, axis=1))

    def moved(self, problem: Problem) -> Array:
        span, wrench = self.span(problem), self._wrench(problem)
        return np.stack([wrench @ bending_compliance(span, one).T for one in _uneven(span)], axis=-1)

    def sentence(self, values: Array) -> str:
        size = float(np.linalg.norm(values)) / self.largest
        return f"It does not bend alike in all directions: 1/EI differs by ±{size:.2g} 1/(N·m²)."

    def _wrench(self, problem: Problem) -> Array:
        """(N, 6) [N, N·m] at the link's end."""
        return np.asarray(problem.nominal_load.local[:, self.slot(problem)])


def _uneven(span: Array) -> tuple[Array, Array]:
    """Two tensors (3, 3) across a link that turn moments of one plane into more bending, of the other into
    less; the planes of one are at 45° to those of the other."""
    along = span / np.linalg.norm(span)
    first = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    first /= np.linalg.norm(first)
    second = np.cross(along, first)
    crossed = np.outer(first, second)
    return np.outer(first, first) - np.outer(second, second), crossed + crossed.T
