"""A joint that remembers where it came from, by what rubs, winds up or creeps behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..base import Depends
from ..kinds import TransmissionEffect
from ..place import Where
from .base import Unnamed, moving, turn

FORGETS = (0.05, 0.2, 0.6)  # rad of travel, after which a joint that rubs has forgotten where it came from


@dataclass(frozen=True)
class Past(Unnamed, TransmissionEffect):
    """A joint's error by its moves since the campaign began, from pose to pose in the order of measurement: z
    goes to the sign of the motion as dz/dq = (sgn q̇ − z) sgn q̇ / d (Dahl 1968) over some distances d; and by
    its last move, part of which is still to come."""

    variant: str = "past"

    lacks: ClassVar[str] = "wait longer at each pose before it is measured, and approach it from both sides"
    depends: ClassVar[Depends] = frozenset({"joints", "time"})
    by_motor: ClassVar[bool] = False

    @property
    def functions(self) -> int:
        return len(FORGETS) + 1

    @property
    def variable(self) -> str:
        return f"where {self.where.joint} came from, in the order of measurement"

    @property
    def like(self) -> str:
        return f"{self.where.joint} resting elsewhere by where it came from"

    def x(self, problem: Problem) -> Array:
        """(N,) [rad] the last move."""
        q = turn(problem)[j := problem.joint(self.where.joint)] * problem.q[:, j]
        order = _order(problem)
        out = np.zeros(len(q))
        out[order[1:]] = np.diff(q[order])
        return out

    def of_joint(self, problem: Problem) -> tuple[int, Array]:
        moves, order = self.x(problem), _order(problem)
        side, kept = np.sign(moves), np.exp(-np.abs(moves)[:, None] / FORGETS)
        z = np.zeros_like(kept)
        for own, k in zip(z.T, kept.T, strict=True):
            to = zip(side[order[1:]].tolist(), k[order[1:]].tolist(), strict=True)
            own[order] = [*accumulate(to, lambda before, s: s[0] + (before - s[0]) * s[1], initial=0.0)]
        return problem.joint(self.where.joint), np.column_stack([z, moves / np.pi])

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        """Nothing: joints alone do not say where they came from."""
        return np.zeros((len(q), self.functions))

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[Unnamed]:
        return [cls(Where(joint=problem.arm.names[j])) for j in moving(problem)]


def _order(problem: Problem) -> NDArray[np.int64]:
    """(N,) numbers of the poses in the order in which they were measured."""
    when = np.arange(len(problem.q)) if problem.time is None else problem.time
    return np.argsort(when, kind="stable")
