"""Springs and drives of the simulated robot, as far as Drake's own elements do not have them."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable, Sequence

import numpy as np

from ...robot.extended_robot.gears import Erring, add_forces
from ...robot.kinematics import Array
from .drives import Drives
from .gears import Gears
from .machine import Machine
from .mechanics import Mechanics


class Springs:
    """Forces that Drake's springs and dampers lack, by positions and velocities of the plant, each (V,).

    softness: (V,) of the springs at the last call, zero where nothing is, Drake's own included. tables:
    motion and torque of the joints whose law is not linear; erring: springs whose gear errs or whose law is
    such; slopes: of the gears' curves at the last call. reaction: whether the motors feel them. linear:
    (V, V) what stays of the step's implicit part.
    """

    def __init__(
        self,
        mechanics: Mechanics,
        machine: Machine,
        drive: Drives,
        gears: Gears,
        reaction: bool,
        step: float,
    ) -> None:
        self.gears, self.reaction, self.step = gears, reaction, step
        self.size = machine.plant.num_velocities()
        self.motors, self.viscous = machine.motors.tolist(), np.zeros(self.size)
        self.viscous[machine.motors] = drive.viscous
        self.softness = np.zeros(self.size)
        self.softness[machine.springs] = machine.stiffness
        damping = self.viscous.copy()
        damping[machine.springs] = machine.damping
        self.tables = {
            j: (law.motion, law.torque)
            for j, law in enumerate(mechanics.axial)
            if law is not None and law.motion is not None and law.torque is not None
        }
        self.erring = [
            self._of(int(j), machine) for j in machine.sprung if gears.err[j] or int(j) in self.tables
        ]
        self.slopes: list[float] = []
        self.linear = np.diag(step / 2 * damping + step**2 / 4 * self.softness)
        for one in self.erring:
            self.linear[one.at, one.at] = 0.0

    def _of(self, j: int, machine: Machine) -> Erring:
        i = int(machine.own[j])
        law = tabulated(*self.tables[j]) if j in self.tables else None
        pairs = [(p, self.motors[c.by]) for p, c in enumerate(self.gears.curves) if c.joint == j]
        stiffness, damping = float(machine.stiffness[i]), float(machine.damping[i])
        return Erring(j, int(machine.springs[i]), stiffness, damping, tuple(pairs), law)

    def add(self, v: Array, at: list[float], side: Sequence[float], force: Array) -> None:
        """Adds them to force (V,) at velocities v (V,), with the whole state `at` [2 V]; motors come from
        `side` [n]."""
        force -= self.viscous * v
        if self.erring:
            errors, self.slopes = self.gears.errors([at[m] for m in self.motors], side)
            add_forces(
                self.erring, at, errors, self.slopes, force, reaction=self.reaction, softness=self.softness
            )

    def implicit(self) -> Array:
        """(V, V) h D/2 + h² K/4 of dampers and springs at the last call.

        Behind a gear that errs a spring is stretched by its own motion less the slope times the motor's: of a
        stiff spring even a slight slope, were it left out here, would make the step diverge.
        """
        h, out = self.step, self.linear.copy()
        for one in self.erring:
            stretch = {one.at: 1.0}
            for pair, motor in one.pairs if self.reaction else ():
                stretch[motor] = stretch.get(motor, 0.0) - self.slopes[pair]
            weight = h / 2 * one.damping + h**2 / 4 * self.softness[one.at]
            for i, along in stretch.items():  # of so few numbers NumPy would take several times as long
                for j, other in stretch.items():
                    out[i, j] += weight * (along * other)
        return out


def tabulated(motion: Array, torque: Array) -> Callable[[float], tuple[float, float]]:
    """A law given as a table: torque and stiffness by a motion."""
    way, pulled = motion.tolist(), torque.tolist()

    def law(x: float) -> tuple[float, float]:
        i = min(max(bisect(way, x), 1), len(way) - 1)
        slope = (pulled[i] - pulled[i - 1]) / (way[i] - way[i - 1])
        return pulled[i - 1] + slope * (x - way[i - 1]), slope

    return law
