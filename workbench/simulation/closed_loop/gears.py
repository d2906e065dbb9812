"""Errors of the transmissions as functions of the motors' angles, fast enough for every step.

What they do to springs and motors stands in `extended_robot/gears.py`, for exports too. Play is a state: a
motor that turns round moves by twice the half width before its joint follows.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...robot.extended_robot.gears import Curve, add_up
from ...robot.kinematics import Array
from ..gear_curves import curves
from .machine import Machine
from .mechanics import Mechanics

MARGIN = 5e-3  # rad, m: how far beyond its command a motor may go
ADDITIVE = 1e-9  # rad, m: what may remain of an error that is no sum over the motors


class Gears:
    """Errors (n,) of the joints by the motors' angles (n,) and sides (n,), with their slopes.

    curves: each of a joint that errs by the angle of one motor. err: (n,) whether a joint's gear has an
    error at all.
    """

    def __init__(self, mechanics: Mechanics, q: Array) -> None:
        """q: (K, n) command, whose range the curves cover."""
        n = mechanics.arm.n
        constant, self.curves = np.zeros(n), []
        if mechanics.gear:
            order = max(effect.where.order or 0.0 for effect, _ in mechanics.gear)
            low, high = q.min(axis=0) - MARGIN, q.max(axis=0) + MARGIN
            constant, found = curves(
                lambda at: mechanics.gear_error(at, np.zeros_like(at)), q[0], low, high, order
            )
            self.curves = [Curve(j, k, samples) for (j, k), samples in found.items()]
        eye = np.eye(n)
        play = np.stack([mechanics.gear_error(q[:1], eye[j : j + 1])[0] - constant for j in range(n)], axis=1)
        self.constant: list[float] = constant.tolist()
        self.play = [(int(i), int(j), float(play[i, j])) for i, j in np.argwhere(play)]
        self.half_width = [(j, max(abs(play[j, j]), 1e-9)) for j in np.flatnonzero(play.any(axis=0)).tolist()]
        self.err = (constant != 0) | play.any(axis=1)
        self.err[[curve.joint for curve in self.curves]] = True
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
        """Errors [n] of the joints and slopes of the curves at motors q [n] that came from `side` [n]."""
        error = self.constant.copy()
        for i, j, width in self.play:
            error[i] += width * side[j]
        return error, add_up(self.curves, q, error)


def of_springs(machine: Machine, errors: Array) -> Array:
    """Errors (n,) of the joints at the springs (K,)."""
    out = np.zeros(len(machine.springs))
    out[: len(machine.sprung)] = errors[machine.sprung]
    return out
