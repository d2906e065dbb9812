"""Friction that remembers: a Dahl element, for what rubs, what winds up and what has play.

Its state s, −1 … 1, goes over to the sign of the motion along a short way c:  ds = (sgn dx − s) |dx| / c
(Dahl 1968). Along one step of dx that is exact:  s → sgn + (s − sgn) exp(−|dx| / c).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...robot.kinematics import Array
from ...robot.loop import Loop
from .drives import Drives
from .machine import Machine


class Rubbing:
    """Dry friction at the n drives, and behind their gears, where motor and spring move together.

    Numbers one by one: of so few, NumPy would take several times as long. memory: [2 n] the states.
    """

    def __init__(self, machine: Machine, drive: Drives, loop: Loop, step: float) -> None:
        n = len(machine.motors)
        self.loop, self.h, self.size = loop, step, machine.plant.num_velocities()
        motors = [(at,) for at in machine.motors.tolist()]
        behind = motors.copy()
        for j, at in zip(machine.sprung.tolist(), machine.own_at.tolist(), strict=True):
            behind[j] = (*behind[j], at)
        self.moving: list[tuple[int, ...]] = [*motors, *behind]
        self.dry = [*((1 - loop.load_side) * drive.coulomb), *(loop.load_side * drive.coulomb)]
        self.memory = [0.0] * (2 * n)

    @property
    def wound(self) -> Array:
        """(n,) what friction behind the gears holds at rest [N·m, N]."""
        n = len(self.dry) // 2
        return np.array(self.dry[n:]) * self.loop.stiction * np.array(self.memory[n:])

    def add(self, v: Sequence[float], force: Array, implicit: memoryview[float]) -> None:
        """Takes its mean over a step at velocities v [V] off the force (V,); adds how that falls with the
        velocities' change to a matrix (V V,).

        It is linearised about the way that the step before makes likely, whose slope by Δv is h/2, not h/4
        as a spring's: twice as soft.
        """
        loop, h, size = self.loop, self.h, self.size
        for s, places, dry in zip(self.memory, self.moving, self.dry, strict=True):
            if not dry:
                continue
            speed = sum([v[at] for at in places])
            mean, slope = mean_on_the_way(s, h * speed, loop.presliding)
            rubs = stribeck(speed, dry, loop.stiction, loop.stribeck_speed)
            soft = h**2 / 2 * rubs * slope
            for at in places:
                force[at] -= rubs * mean
                for other in places:
                    implicit[at * size + other] += soft

    def go(self, moved: Sequence[float]) -> None:
        """Remembers a motion [V]."""
        way = self.loop.presliding
        self.memory = [
            gone_over(s, sum([moved[at] for at in places]), way)
            for s, places in zip(self.memory, self.moving, strict=True)
        ]


def gone_over(s: float, dx: float, way: float) -> float:
    """State after a motion dx [rad, m] from state s."""
    sign = (dx > 0) - (dx < 0)
    return sign + (s - sign) * math.exp(-abs(dx) / way)


def mean_on_the_way(s: float, dx: float, way: float) -> tuple[float, float]:
    """Mean of the state along a motion dx, and its slope by dx [1/rad, 1/m]; the slope is not negative."""
    sign = (dx > 0) - (dx < 0)
    a = abs(dx) / way + 1e-4
    left = math.exp(-a)
    share = (1 - left) / a
    return sign + (s - sign) * share, (sign * s - 1) * (left - share) / (a * way)


def stribeck(v: float, coulomb: float, stiction: float, speed: float) -> float:
    """Size of dry friction [N·m, N] at speed v: higher at rest by `stiction`."""
    return coulomb * (1 + (stiction - 1) * math.exp(-((v / speed) ** 2)))
