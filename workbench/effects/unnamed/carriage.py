"""What a carriage does under its load beside turning alike about all axes: a companion of one that tilts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...campaign.problem import Problem
from ...robot.kinematics import Arm, Array
from ...robot.rotations import skew
from ..place import Where
from .loads import Uneven


def at_carriage(arm: Arm, slot: int) -> Array:
    """(3, 6) moment at the origin of the frame before a slot of a wrench at that slot, on the slot's axes."""
    return np.concatenate([skew(arm.span[slot]), np.eye(3)], axis=1)


@dataclass(frozen=True)
class UnevenCarriage(Uneven):
    """A carriage on its guide is not as stiff in roll as in pitch and yaw, which a long one hardly does, nor
    in these alike, whichever two axes across the guide they go about: its compliance is a symmetrical tensor
    that is more about one axis and less about others."""

    variant: str = "uneven carriage"

    functions: ClassVar[int] = 3

    @property
    def variable(self) -> str:
        return f"moment on the carriage of {self.where.joint}"

    def slot(self, arm: Arm) -> int:
        return arm.slot_of_joint(str(self.where.joint)) + 1

    def moment(self, problem: Problem) -> Array:
        """(N, 3) [N·m] at the carriage, on the axes of its joint."""
        arm, slot = problem.arm, self.slot(problem.arm)
        return np.asarray(problem.nominal_load.local[:, slot] @ at_carriage(arm, slot).T @ arm.R[slot].T)

    def motion(self, problem: Problem) -> Mapping[int, Array]:
        arm, slot = problem.arm, self.slot(problem.arm)
        x, y, z = self.moment(problem).T / self.largest
        none = np.zeros_like(x)
        turn = np.array([[-x / 2, x, y], [-y / 2, -y, x], [z, none, none]])  # (3, functions, N)
        moved = np.einsum("ci,ij,jfn->cnf", at_carriage(arm, slot).T, arm.R[slot].T, turn)
        return {6 * slot + c: moved[c] for c in range(6)}

    def sentence(self, values: Array) -> str:
        per_kNm = values / self.largest * 1e9
        across = per_kNm[0] / -2 + np.hypot(*per_kNm[1:])
        return (
            f"It is not alike about all axes: {per_kNm[0]:+.2g} µrad per kN·m in roll, up to {across:+.2g} "
            "about an axis across the guide."
        )

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[UnevenCarriage]:
        """Sliding joints that carry a moment."""
        names = problem.arm.names
        return cls.bearing(problem, [Where(joint=names[j]) for j in np.flatnonzero(problem.arm.prismatic)])
