"""Springs, dampers and gears of the simulated robot, as far as Drake's own elements do not have them."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...robot.kinematics import Array
from .drives import Drives
from .gears import Gears
from .machine import Machine
from .mechanics import Mechanics

SCREW_DAMPING = 6e-4  # s: damping of a yielding screw over its stiffness


def spring_damping(mechanics: Mechanics, drive: Drives) -> Array:
    """(K,) damping of the springs [N·m·s/rad, N·s/m]: the joints' own, then the screws."""
    own = [drive.damping[j] for j, law in enumerate(mechanics.axial) if law is not None]
    return np.array([*own, *(SCREW_DAMPING / screw.compliance for screw in mechanics.screws)])


@dataclass(frozen=True, eq=False)
class _Erring:
    """A joint whose gear errs or whose law is not linear: its number, its spring's place, stiffness and
    damping, the pairs of its gear with their motors' places, and its law as a table."""

    joint: int
    at: int
    stiffness: float
    damping: float
    pairs: tuple[tuple[int, int], ...]
    table: tuple[list[float], list[float]] | None


class Springs:
    """Forces of the springs by positions and velocities of the plant, each (V,).

    softness: (V,) slopes of the springs at the last call, damping: (V,), zero where nothing is; reaction:
    whether the motors feel the gears' slopes.
    """

    def __init__(
        self, mechanics: Mechanics, machine: Machine, drive: Drives, gears: Gears, reaction: bool
    ) -> None:
        self.gears, self.reaction = gears, reaction
        self.size = machine.plant.num_velocities()
        self.motors = machine.motors.tolist()
        self.softness, self.damping = np.zeros(self.size), np.zeros(self.size)
        self.softness[machine.springs] = machine.stiffness
        self.damping[machine.motors] = drive.viscous
        self.damping[machine.springs] = spring_damping(mechanics, drive)
        drakes = np.zeros(self.size, dtype=bool)
        drakes[machine.springs] = machine.native
        others = np.where(drakes, 0.0, self.softness)
        self.of_state = np.hstack([np.diag(others), np.diag(self.damping)])
        self.erring = [
            self._of(int(j), mechanics, machine)
            for j in machine.sprung
            if gears.err[j] or mechanics.axial[j].torque is not None
        ]

    def _of(self, j: int, mechanics: Mechanics, machine: Machine) -> _Erring:
        at, law = int(machine.springs[machine.own[j]]), mechanics.axial[j]
        pairs = tuple((int(p), self.motors[self.gears.by[p]]) for p in np.flatnonzero(self.gears.joint == j))
        table = None
        if law is not None and law.motion is not None and law.torque is not None:
            table = law.motion.tolist(), law.torque.tolist()
        return _Erring(j, at, float(self.softness[at]), float(self.damping[at]), pairs, table)

    def add(self, x: Array, at: list[float], side: Sequence[float], force: Array) -> None:
        """Adds to force (V,) what Drake's springs at x (2 V,), `at` as a list, lack; motors come from `side`
        [n]."""
        size = self.size
        force -= self.of_state @ x
        if not self.erring:
            return
        errors, slope = self.gears.errors([at[m] for m in self.motors], side)
        for one in self.erring:
            q, v = at[one.at], at[size + one.at]
            stretch, rate = q - errors[one.joint], 0.0
            for pair, motor in one.pairs:
                rate += slope[pair] * at[size + motor]
            if one.table is None:
                pull = one.stiffness * stretch
            else:
                pull, self.softness[one.at] = tabulated(stretch, *one.table)
            force[one.at] += one.stiffness * q - pull + one.damping * rate
            if self.reaction and one.pairs:
                pull += one.damping * (v - rate)
                for pair, motor in one.pairs:
                    force[motor] += slope[pair] * pull


def tabulated(x: float, way: list[float], torque: list[float]) -> tuple[float, float]:
    """Torque and stiffness at a motion x of a law given as a table."""
    i = min(max(bisect(way, x), 1), len(way) - 1)
    slope = (torque[i] - torque[i - 1]) / (way[i] - way[i - 1])
    return torque[i - 1] + slope * (x - way[i - 1]), slope
