"""A compensator's gas from the pressures that its gauge showed at some angles of the joint.

    gas    p = p₀ (l/(l − Δs))^n          Δs: how far the pivots are beyond their shortest distance
    coil   p = p₀ + k Δs                  what a spring's force over the piston's area would show

Over a short stroke l and n say the same thing: one of them has to be known, n = 1 at rest or l = V/A from the
tank's volume.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ...robot.kinematics import Array
from .gas_spring import Linkage

DECIDES = 20.0  # odds: as rare as a test at 5 %


@dataclass(frozen=True)
class PressureFit:
    """A law fitted to M pressures.

    values: precharge [Pa], then length [m] or exponent of the gas, or the coil's rate [Pa/m]; std: their
    standard deviations, from the scatter; rms [Pa]; count: M.
    """

    values: Array
    std: Array
    rms: float
    count: int


def fit_gas(triangle: Linkage, q: Array, pressure: Array, *, length: float | None = None) -> PressureFit:
    """Precharge and gas length of an isothermal gas; with a known `length` [m], precharge and exponent.

    q: (M,) [rad] of the joint, pressure: (M,) [Pa] absolute, M > 2.
    """
    ds = _beyond_shortest(triangle, q)
    if length is not None:

        def gas(x: Array) -> Array:
            return x[0] * (length / (length - ds)) ** x[1]

        return _fitted(gas, pressure, np.array([pressure.min(), 1.0]))

    def gas_of_length(x: Array) -> Array:
        return x[0] * x[1] / (x[1] - ds)

    start = np.array([pressure.min(), 5 * float(ds.max())])
    return _fitted(gas_of_length, pressure, start)


def fit_coil(triangle: Linkage, q: Array, pressure: Array) -> PressureFit:
    """Preload and rate of the coil spring that would show these pressures; arguments as `fit_gas`."""
    ds = _beyond_shortest(triangle, q)

    def line(x: Array) -> Array:
        return x[0] + x[1] * ds

    start = np.array([pressure.min(), np.ptp(pressure) / float(ds.max())])
    return _fitted(line, pressure, start)


def odds(one: PressureFit, other: PressureFit) -> float:
    """How much likelier the pressures are under `one`: both with two parameters and unknown noise."""
    return float((other.rms / one.rms) ** one.count)


def told_apart(one: PressureFit, other: PressureFit) -> bool:
    """Whether the pressures decide between the two laws."""
    ratio = odds(one, other)
    return max(ratio, 1 / ratio) > DECIDES


def _beyond_shortest(triangle: Linkage, q: Array) -> Array:
    return triangle.stretch(q)[0] - abs(triangle.a - triangle.L)


def _fitted(law: Callable[[Array], Array], pressure: Array, start: Array) -> PressureFit:
    def left(x: Array) -> Array:
        return (law(x * start) - pressure) / pressure.mean()

    found = least_squares(left, np.ones(2), xtol=1e-14, ftol=1e-14, gtol=1e-14)
    scatter = float(found.fun @ found.fun) / (len(pressure) - 2)
    J: Array = np.asarray(found.jac)
    covariance = np.linalg.inv(J.T @ J) * scatter
    rms = float(np.sqrt((found.fun**2).mean()) * pressure.mean())
    std = np.sqrt(np.diag(covariance)) * np.abs(start)
    return PressureFit(found.x * start, std, rms, len(pressure))
