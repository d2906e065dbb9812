"""Friction that remembers: a Dahl element, for what rubs, what winds up and what has play.

Its state s, −1 … 1, goes over to the sign of the motion along a short way c:  ds = (sgn dx − s) |dx| / c
(Dahl 1968). Along one step of dx that is exact:  s → sgn + (s − sgn) exp(−|dx| / c).
"""

from __future__ import annotations

import numpy as np

from ...robot.kinematics import Array


def gone_over(s: Array, dx: Array, way: Array) -> Array:
    """State after motions dx (m,) [rad, m] from state s (m,)."""
    sign = np.sign(dx)
    return np.asarray(sign + (s - sign) * np.exp(-np.abs(dx) / way))


def mean_on_the_way(s: Array, dx: Array, way: Array) -> tuple[Array, Array]:
    """Mean of the state along motions dx (m,), and its slope by dx [1/rad, 1/m]; the slope is not
    negative."""
    sign = np.sign(dx)
    a = np.abs(dx) / way + 1e-4
    left = np.exp(-a)
    share = (1 - left) / a
    gone = s - sign
    slope = (sign * s - 1) * (left - share) / (a * way)
    return sign + gone * share, slope


def stribeck(v: Array, coulomb: Array, stiction: float, speed: float) -> Array:
    """Size of dry friction (m,) [N·m, N] at speeds v (m,): higher at rest by `stiction`."""
    return np.asarray(coulomb * (1 + (stiction - 1) * np.exp(-((v / speed) ** 2))))
