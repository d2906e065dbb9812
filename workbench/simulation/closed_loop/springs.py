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

    softness: (V,) slopes of the springs at the last call, damping: (V,), zero where nothing is; both are for
    the implicit step, Drake's own springs and dampers included. tables: motion and torque of the joints whose
    law is not linear; bent: those joints. reaction: whether the motors feel the gears' slopes.
    """

    def __init__(
        self, mechanics: Mechanics, machine: Machine, drive: Drives, gears: Gears, reaction: bool
    ) -> None:
        self.gears, self.reaction = gears, reaction
        self.size = machine.plant.num_velocities()
        self.motors, self.viscous = machine.motors.tolist(), np.zeros(self.size)
        self.viscous[machine.motors] = drive.viscous
        self.softness = np.zeros(self.size)
        self.softness[machine.springs] = machine.stiffness
        self.damping = self.viscous.copy()
        self.damping[machine.springs] = machine.damping
        self.tables = {
            j: (law.motion, law.torque)
            for j, law in enumerate(mechanics.axial)
            if law is not None and law.motion is not None and law.torque is not None
        }
        self.erring = [
            self._of(int(j), machine) for j in machine.sprung if gears.err[j] or int(j) in self.tables
        ]
        self.bent = [one for one in self.erring if one.law is not None]

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
            errors, slopes = self.gears.errors([at[m] for m in self.motors], side)
            add_forces(self.erring, at, errors, slopes, force, reaction=self.reaction, softness=self.softness)


def tabulated(motion: Array, torque: Array) -> Callable[[float], tuple[float, float]]:
    """A law given as a table: torque and stiffness by a motion."""
    way, pulled = motion.tolist(), torque.tolist()

    def law(x: float) -> tuple[float, float]:
        i = min(max(bisect(way, x), 1), len(way) - 1)
        slope = (pulled[i] - pulled[i - 1]) / (way[i] - way[i - 1])
        return pulled[i - 1] + slope * (x - way[i - 1]), slope

    return law
