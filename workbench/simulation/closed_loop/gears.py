"""Errors of the transmissions as functions of the motors' angles, fast enough for every step.

Of a transmission with error δ(q_m), V = U(e − δ): the spring pulls back with U′(e − δ) at its own
coordinate, and the motor feels δ′ᵀ U′. Without that reaction the tool is wrong by nearly the effect itself.
Play is a state: a motor that turns round moves by twice the half width before its joint follows.
"""

from __future__ import annotations

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
    """

    def __init__(self, mechanics: Mechanics, q: Array) -> None:
        """q: (K, n) command, whose range the tables cover."""
        n = mechanics.arm.n
        self.at_rest, none = q[0], np.zeros(n)
        low, high = q.min(axis=0) - MARGIN, q.max(axis=0) + MARGIN
        self.constant = mechanics.gear_error(q[:1], none[None])[0]
        joint, by, tables = [], [], []
        self.low, self.fine = np.zeros(0), np.zeros(0)
        for j in range(n) if mechanics.gear else ():
            count = int(np.clip(np.ceil((high[j] - low[j]) / FINE), 1000, MOST))
            there = np.tile(q[0], (count, 1))
            there[:, j] = np.linspace(low[j], high[j], count)
            error = mechanics.gear_error(there, np.zeros_like(there)) - self.constant
            fine = (high[j] - low[j]) / (count - 1)
            for i in np.flatnonzero(np.ptp(error, axis=0) > 0):
                joint.append(int(i))
                by.append(j)
                tables.append(np.stack([error[:, i], np.gradient(error[:, i], fine)], axis=1))
                self.low, self.fine = np.append(self.low, low[j]), np.append(self.fine, fine)
        self.joint, self.by = np.array(joint, dtype=np.int64), np.array(by, dtype=np.int64)
        sizes = [len(table) for table in tables]
        self.start = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64) if sizes else self.joint
        self.last = np.array(sizes, dtype=np.int64) - 2
        self.table = np.concatenate(tables) if tables else np.zeros((0, 2))
        eye = np.eye(n)
        self.play = np.stack(
            [mechanics.gear_error(q[:1], eye[j : j + 1])[0] - self.constant for j in range(n)], axis=1
        )
        self.sided = bool(self.play.any())
        self.half_width = np.maximum(np.abs(np.diag(self.play)), 1e-9)
        self.sum = np.zeros((n, len(joint)))
        self.sum[self.joint, np.arange(len(joint))] = 1.0
        self._check(mechanics, q)

    def _check(self, mechanics: Mechanics, q: Array) -> None:
        some = q[:: max(1, len(q) // 16)]
        side = np.ones(q.shape[1])
        for place, exact in zip(some, mechanics.gear_error(some, np.tile(side, (len(some), 1))), strict=True):
            if np.abs(self.errors(place, side)[0] - exact).max() > ADDITIVE + 1e-3 * np.abs(exact).max():
                raise ValueError("a gear's error that is no sum of functions of one motor each")

    def crossed(self, side: Array, moved: Array) -> Array:
        """Sides (n,), −1 … 1, after the motors have `moved` (n,) [rad, m]."""
        return np.minimum(np.maximum(side + moved / self.half_width, -1.0), 1.0)

    def errors(self, q: Array, side: Array) -> tuple[Array, Array]:
        """Errors (n,) of the joints and slopes (P,) of the pairs at motors q (n,) that came from `side`."""
        error = self.constant + self.play @ side if self.sided else self.constant
        if not len(self.by):
            return error, np.zeros(0)
        x = (q[self.by] - self.low) / self.fine
        cell = np.minimum(np.maximum(x.astype(np.int64), 0), self.last)
        at = self.start + cell
        before = self.table[at]
        here = before + (x - cell)[:, None] * (self.table[at + 1] - before)
        return error + self.sum @ here[:, 0], here[:, 1]

    def slopes(self, q: Array) -> Array:
        """(n, n) of the joints' errors by the motors' angles."""
        out = np.zeros((len(q), len(q)))
        out[self.joint, self.by] = self.errors(q, np.zeros_like(q))[1]
        return out


def of_springs(machine: Machine, errors: Array) -> Array:
    """Errors (n,) of the joints at the springs (K,)."""
    out = np.zeros(len(machine.springs))
    out[: len(machine.sprung)] = errors[machine.sprung]
    return out
