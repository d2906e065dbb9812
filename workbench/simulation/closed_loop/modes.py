"""The lowest modes of the arm on its springs, and how far they hang on a drive's inertia that is assumed.

Drives locked, the links swing behind motors that hold still: no rotor counts. Drives free, a motor swings
against its links: K (1/J_motor + 1/J_link), the resonance that a velocity loop meets.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...report.numbers import significant
from ...robot.kinematics import Array
from .drives import Drives
from .machine import Machine, machine, mass_matrix
from .mechanics import Mechanics

SHOWN = 3  # modes


@dataclass(frozen=True)
class Modes:
    """Lowest natural frequencies [Hz], ascending, of springs and masses alone: drives locked, and free.

    halved, doubled: drives free, with half and twice the inertia of those drives for which none is stated
    (`guessed`, names); empty where all is stated. All empty where nothing yields."""

    locked: tuple[float, ...] = ()
    free: tuple[float, ...] = ()
    guessed: tuple[str, ...] = ()
    halved: tuple[float, ...] = ()
    doubled: tuple[float, ...] = ()

    def to_json(self) -> dict[str, Any]:
        return {
            "drives_locked": _short(self.locked),
            "drives_free": _short(self.free),
            "inertia_assumed_of": list(self.guessed),
            "drives_free_inertia_halved": _short(self.halved),
            "drives_free_inertia_doubled": _short(self.doubled),
        }

    def facts(self) -> list[tuple[str, str]]:
        """For the page: what, and the frequencies."""
        if not self.locked:
            return []
        facts = [
            ("Lowest modes at the path's start, drives locked", _listed(self.locked)),
            ("The same, drives free", _listed(self.free)),
        ]
        if self.guessed:
            said = f"halved {_listed(self.halved)}, doubled {_listed(self.doubled)}"
            facts.append((f"… with the assumed inertia of the drives of {', '.join(self.guessed)}", said))
        return facts


def modes(mechanics: Mechanics, drive: Drives, q: Array) -> Modes:
    """Of the simulated robot at joints q (n,)."""
    built = machine(mechanics, drive)
    if not len(built.springs):
        return Modes()
    locked, free = frequencies(built, q, free=False), frequencies(built, q, free=True)
    if not drive.guessed.any():
        return Modes(_lowest(locked), _lowest(free))
    halved, doubled = (
        frequencies(
            machine(mechanics, replace(drive, rotor=np.where(drive.guessed, factor, 1.0) * drive.rotor)),
            q,
            free=True,
        )
        for factor in (0.5, 2.0)
    )
    names = tuple(mechanics.arm.names[j] for j in np.flatnonzero(drive.guessed))
    return Modes(_lowest(locked), _lowest(free), names, _lowest(halved), _lowest(doubled))


def frequencies(built: Machine, q: Array, *, free: bool) -> Array:
    """(K,) natural frequencies [rad/s] of the arm on its K springs at joints q (n,), ascending.

    free: the drives swing along without torque, so that M = M_ss − M_sm M_mm⁻¹ M_ms acts on the springs;
    otherwise they are locked."""
    whole = mass_matrix(built, q)
    M = whole[np.ix_(built.springs, built.springs)]
    if free:
        beside = whole[np.ix_(built.motors, built.springs)]
        M = M - beside.T @ np.linalg.solve(whole[np.ix_(built.motors, built.motors)], beside)
    scale = 1 / np.sqrt(built.stiffness)
    slowness = np.maximum(np.linalg.eigvalsh(scale[:, None] * M * scale), 1e-12)
    return np.asarray(1 / np.sqrt(slowness[::-1]))


def _lowest(found: Array) -> tuple[float, ...]:
    return tuple(float(f) for f in found[:SHOWN] / (2 * np.pi))


def _listed(values: tuple[float, ...]) -> str:
    return ", ".join(significant(f, 3) for f in values) + " Hz"


def _short(values: tuple[float, ...]) -> list[float]:
    """Six significant digits."""
    return [float(f"{f:.6g}") for f in values]
