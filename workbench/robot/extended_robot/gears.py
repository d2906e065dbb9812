"""Errors of gears as functions of the motors' angles, and what they do to the springs behind them.

Of a gear with error δ(q_m) before a spring U(e), the spring pulls back with U′(e − δ) at its own coordinate,
and the motor feels δ′ᵀ U′. Without that reaction the tool is wrong by nearly the effect itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.trajectories import PiecewisePolynomial


class Curve:
    """Something at joint `joint` as a function of joint `by`: cubic between even samples, straight on
    beyond.

    Numbers one by one: of so few, NumPy would take several times as long.
    """

    def __init__(self, joint: int, by: int, samples: Any) -> None:
        """samples: (2, M) positions of joint `by` [rad, m], and values there."""
        self.joint, self.by = joint, by
        at, values = samples
        self.low, self.fine, self.last = float(at[0]), float(at[-1] - at[0]) / (len(at) - 1), len(at) - 2
        spline = PiecewisePolynomial.CubicWithContinuousSecondDerivatives(at, values[None])
        slopes = self.fine * spline.derivative().vector_values(at)[0]
        start, rise = slopes[:-1], np.diff(values)
        cells = values[:-1], start, 3 * rise - 2 * start - slopes[1:], start + slopes[1:] - 2 * rise
        self._cells = [np.ascontiguousarray(part).data for part in cells]

    def at(self, q: float) -> tuple[float, float]:
        """Value and slope at a position q of joint `by`."""
        x = (q - self.low) / self.fine
        cell = min(max(int(x), 0), self.last)
        x -= cell
        at = min(max(x, 0.0), 1.0)
        a, b, c, d = (part[cell] for part in self._cells)
        slope = b + at * (2 * c + 3 * at * d)
        return a + at * (b + at * (c + at * d)) + (x - at) * slope, slope / self.fine


def add_up(curves: Sequence[Curve], q: Sequence[float], sums: list[float]) -> list[float]:
    """Adds all curves at joints q [n] to `sums` [n]; the slopes of each."""
    slopes = []
    for curve in curves:
        value, slope = curve.at(q[curve.by])
        sums[curve.joint] += value
        slopes.append(slope)
    return slopes


@dataclass(frozen=True, eq=False)
class Erring:
    """The spring of a joint whose gear errs, or whose law is not linear.

    joint: its number; at: place of its spring among positions and velocities; stiffness, damping: of Drake's
    own spring and damper there; pairs: of its gear's curves, their numbers and the places of the motors that
    they depend on. law: torque and stiffness by motion, where the spring is not Drake's.
    """

    joint: int
    at: int
    stiffness: float
    damping: float
    pairs: tuple[tuple[int, int], ...]
    law: Callable[[float], tuple[float, float]] | None = None


def add_forces(
    springs: Sequence[Erring],
    x: Sequence[float],
    errors: Sequence[float],
    slopes: Sequence[float],
    force: Any,
    *,
    reaction: bool = True,
    softness: Any = None,
) -> None:
    """Adds to generalised forces (V,) what Drake's springs and dampers lack at states x [2 V].

    errors: [n] of the joints' gears, slopes: of their curves. reaction: whether the motors feel it. softness:
    (V,), takes the slopes of the laws that are not linear.
    """
    size = len(force)
    for one in springs:
        q, v, rate = x[one.at], x[size + one.at], 0.0
        for pair, motor in one.pairs:
            rate += slopes[pair] * x[size + motor]
        stretch = q - errors[one.joint]
        if one.law is None:
            pull = one.stiffness * stretch
            force[one.at] += one.stiffness * q - pull + one.damping * rate
        else:
            pull, softness[one.at] = one.law(stretch)
            force[one.at] += one.damping * rate - pull
        if reaction and one.pairs:
            pull += one.damping * (v - rate)
            for pair, motor in one.pairs:
                force[motor] += slopes[pair] * pull
