"""Errors of the transmissions as functions of the motors' angles, fast enough for every step.

Of a transmission with error δ(q_m), V = U(e − δ): the spring pulls back with U′(e − δ) at its own
coordinate, and the motor feels δ′ᵀ U′. Without that reaction the tool is wrong by nearly the effect itself.
Play is a state: a motor that turns round moves by twice the half width before its joint follows.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...robot.kinematics import Array
from .machine import Machine
from .mechanics import Mechanics

FINE = 2e-5  # rad, m: between entries of a table: 1/400 of a cycle of 800 per turn
MOST = 400_001  # entries
MARGIN = 5e-3  # rad, m: how far beyond its command a motor may go
ADDITIVE = 1e-9  # rad, m: what may remain of an error that is no sum over the motors


class Gears:
    """Errors (n,) of the joints by the motors' angles (n,) and sides (n,), with their slopes.

    pairs: (P,) joint that errs and motor that it errs with, `by`; both index joints.
    err: (n,) whether a joint's gear has an error at all.
    """

    def __init__(self, mechanics: Mechanics, q: Array) -> None:
        """q: (K, n) command, whose range the tables cover."""
        n = mechanics.arm.n
        self.at_rest, none = q[0], np.zeros(n)
        low, high = q.min(axis=0) - MARGIN, q.max(axis=0) + MARGIN
        constant = mechanics.gear_error(q[:1], none[None])[0]
        joint, by = [], []
        self.tables: list[tuple[int, int, float, float, int, memoryview, memoryview]] = []
        for j in range(n) if mechanics.gear else ():
            count = int(np.clip(np.ceil((high[j] - low[j]) / FINE), 1000, MOST))
            there = np.tile(q[0], (count, 1))
            there[:, j] = np.linspace(low[j], high[j], count)
            error = mechanics.gear_error(there, np.zeros_like(there)) - constant
            fine = (high[j] - low[j]) / (count - 1)
            for i in np.flatnonzero(np.ptp(error, axis=0) > 0):
                joint.append(int(i))
                by.append(j)
                values, slopes = error[:, i].copy(), np.gradient(error[:, i], fine)
                self.tables.append(
                    (int(i), j, float(low[j]), float(fine), count - 2, values.data, slopes.data)
                )
        self.joint, self.by = np.array(joint, dtype=np.int64), np.array(by, dtype=np.int64)
        eye = np.eye(n)
        play = np.stack([mechanics.gear_error(q[:1], eye[j : j + 1])[0] - constant for j in range(n)], axis=1)
        self.constant: list[float] = constant.tolist()
        self.play = [(int(i), int(j), float(play[i, j])) for i, j in np.argwhere(play)]
        self.half_width = [(j, max(abs(play[j, j]), 1e-9)) for j in np.flatnonzero(play.any(axis=0)).tolist()]
        self.err = (constant != 0) | play.any(axis=1)
        self.err[self.joint] = True
        self._check(mechanics, q)

    def _check(self, mechanics: Mechanics, q: Array) -> None:
        some = q[:: max(1, len(q) // 16)]
        side = [1.0] * q.shape[1]
        for place, exact in zip(some, mechanics.gear_error(some, np.tile(side, (len(some), 1))), strict=True):
            if (
                np.abs(self.errors(place.tolist(), side)[0] - exact).max()
                > ADDITIVE + 1e-3 * np.abs(exact).max()
            ):
                raise ValueError("a gear's error that is no sum of functions of one motor each")

    def crossed(self, side: Sequence[float], moved: Sequence[float]) -> list[float]:
        """Sides [n], −1 … 1, after the motors have `moved` [n] [rad, m]."""
        out = list(side)
        for j, width in self.half_width:
            out[j] = min(max(side[j] + moved[j] / width, -1.0), 1.0)
        return out

    def errors(self, q: Sequence[float], side: Sequence[float]) -> tuple[list[float], list[float]]:
        """Errors [n] of the joints and slopes [P] of the pairs at motors q [n] that came from `side` [n].

        Numbers one by one: of so few, NumPy would take several times as long.
        """
        error, slope = self.constant.copy(), []
        for i, j, width in self.play:
            error[i] += width * side[j]
        for joint, by, low, fine, last, values, slopes in self.tables:
            x = (q[by] - low) / fine
            cell = min(max(int(x), 0), last)
            x -= cell
            error[joint] += values[cell] + x * (values[cell + 1] - values[cell])
            slope.append(slopes[cell] + x * (slopes[cell + 1] - slopes[cell]))
        return error, slope

    def slopes(self, q: Array) -> Array:
        """(n, n) of the joints' errors by the motors' angles."""
        out = np.zeros((len(q), len(q)))
        out[self.joint, self.by] = self.errors(q.tolist(), [0.0] * len(q))[1]
        return out


def of_springs(machine: Machine, errors: Array) -> Array:
    """Errors (n,) of the joints at the springs (K,)."""
    out = np.zeros(len(machine.springs))
    out[: len(machine.sprung)] = errors[machine.sprung]
    return out
