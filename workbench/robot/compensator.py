"""The gravity compensator: the force with which it pulls its two pivots together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from .description import Robot
from .extended_robot.cylinder import gas_force
from .kinematics import Arm, Array, Frames
from .schema import Compensator


@dataclass(frozen=True)
class CompensatorLaw:
    """Force of a compensator, F(s) in N > 0 when it pulls its pivots together; s in m.

    `charge` scales the absolute gas pressure, or the spring's rate (1 = nominal), for all poses or for
    each (N,); `preload` [N] adds to the force.
    """

    data: Compensator
    body: int
    arm: int
    body_pivot: Array
    arm_pivot: Array
    charge: float | Array = 1.0
    preload: float = 0.0

    def force(self, s: Array) -> tuple[Array, Array, Array]:
        """F, dF/ds and dF/dcharge at pivot distances s: (N,)."""
        by_charge, by_length, constant = _force(self.data, s)
        return self.charge * by_charge + constant + self.preload, self.charge * by_length, by_charge

    def pull(self, s: float, charge: float, preload: float) -> float:
        """F [N] at one pivot distance s [m], with that charge and preload in place of the law's own."""
        by_charge, _, constant = _force(self.data, s)
        return charge * by_charge + constant + preload

    def by_exponent(self, s: Array) -> Array:
        """dF/dn (N,) [N] of a gas at pivot distances s (N,) [m]: (l/column)^n grows with n by ln(l/column)
        times itself. Raises ValueError for a spring, whose force has no exponent."""
        length, reference = self.data.gas_length, self.data.reference
        if length is None or reference is None:
            raise ValueError("a coil spring has no polytropic exponent")
        return np.asarray(self.charge * self.force(s)[2] * np.log(length / (length - (s - reference))))

    def of_exponent(self, exponent: float) -> CompensatorLaw:
        """The same gas with another polytropic exponent."""
        return replace(self, data=self.data.model_copy(update={"exponent": exponent}))

    @property
    def coil(self) -> tuple[float, float] | None:
        """Rate [N/m] and free length [m] of the coil spring that pulls as this does; None where none does: a
        gas, a spring whose rate changes, or one that would be slack at no length."""
        if self.data.kind != "spring" or np.ptp(self.charge) > 0:
            return None
        assert self.data.rate is not None
        assert self.data.free_length is not None
        rate = float(np.ravel(self.charge)[0]) * self.data.rate  # of a mean the rounding hangs on the number
        free = self.data.free_length - self.preload / rate if rate > 0 else 0.0
        return (rate, free) if free > 0 else None

    def ends(self, where: Frames) -> tuple[Array, Array, Array]:
        """Moving pivot (N, 3), unit vector from it to the fixed pivot (N, 3), distance (N,)."""
        a = where.p[self.arm] + where.R[self.arm] @ self.arm_pivot
        b = where.p[self.body] + where.R[self.body] @ self.body_pivot
        s = np.linalg.norm(b - a, axis=1)
        return a, (b - a) / s[:, None], s


Length = TypeVar("Length", float, Array)


def _force(data: Compensator, s: Length) -> tuple[Length, Length, float]:
    """Force that the charge multiplies, its slope by s, and force beside it, at pivot distance s."""
    if data.kind == "spring":
        assert data.rate is not None
        assert data.free_length is not None
        return data.rate * (s - data.free_length), data.rate + 0 * s, 0.0
    assert data.piston_area
    assert data.precharge
    assert data.gas_length
    assert data.reference is not None
    return gas_force(s, data.piston_area, data.precharge, data.gas_length, data.reference, data.exponent)


def compensator_law(robot: Robot, arm: Arm) -> CompensatorLaw | None:
    """The TOML's compensator in the arm's frames."""
    data = robot.compensator
    if data is None:
        return None
    body, moving = arm.slot_of_link(data.body), arm.slot_of_link(data.arm)
    return CompensatorLaw(
        data,
        body,
        moving,
        arm.R_link[body] @ np.array(data.body_pivot),
        arm.R_link[moving] @ np.array(data.arm_pivot),
    )
