"""The gravity compensator: the force with which it pulls its two pivots together."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .description import Robot
from .kinematics import Arm, Array, Frames
from .schema import Compensator

ATMOSPHERE = 101325.0  # Pa


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
        d = self.data
        if d.kind == "spring":
            assert d.rate is not None
            assert d.free_length is not None
            pull = d.rate * (s - d.free_length)
            return self.charge * pull + self.preload, self.charge * np.full_like(s, d.rate), pull
        assert d.piston_area
        assert d.precharge
        assert d.gas_length
        assert d.reference is not None
        length = d.gas_length - (s - d.reference)
        gas = d.piston_area * d.precharge * (d.gas_length / length) ** d.exponent
        force = self.charge * gas - d.piston_area * ATMOSPHERE + self.preload
        return force, self.charge * gas * d.exponent / length, gas

    def pull(self, s: float, charge: float, preload: float) -> float:
        """F [N] at one pivot distance s [m], with that charge and preload in place of the law's own."""
        return float(replace(self, charge=charge, preload=preload).force(np.array([s]))[0][0])

    @property
    def coil(self) -> tuple[float, float] | None:
        """Rate [N/m] and free length [m] of the coil spring that pulls as this does; None where none does: a
        gas, or a spring that would be slack at no length."""
        if self.data.kind != "spring":
            return None
        assert self.data.rate is not None
        assert self.data.free_length is not None
        rate = float(np.mean(self.charge)) * self.data.rate
        free = self.data.free_length - self.preload / rate if rate > 0 else 0.0
        return (rate, free) if free > 0 else None

    def ends(self, where: Frames) -> tuple[Array, Array, Array]:
        """Moving pivot (N, 3), unit vector from it to the fixed pivot (N, 3), distance (N,)."""
        a = where.p[self.arm] + where.R[self.arm] @ self.arm_pivot
        b = where.p[self.body] + where.R[self.body] @ self.body_pivot
        s = np.linalg.norm(b - a, axis=1)
        return a, (b - a) / s[:, None], s


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
