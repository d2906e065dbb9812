"""What is commanded, over time: the path's joints as smooth motion from rest to rest, on the integrator's grid.

Joints run through the samples of the command as a cubic spline (continuous acceleration). The path's own
time is slowed at both ends by a quintic ramp, so that the arm starts and ends at rest with bounded jerk.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from ..arm import Array

LEAD = 0.1  # s of rest before the path
TRAIL = 0.05
RAMP = 0.2
SETTLING = 5e-6  # rad, m: way within which a joint that turns round goes to the other side of its play


@dataclass(frozen=True, eq=False)
class Motion:
    """Commanded joints at K instants, `period` apart: q, v, a (K, n) [rad, m, s].

    sample_times: (N,) [s] when the path's samples are passed. side: (K, n) side of approach, −1 … 1.
    """

    period: float
    q: Array
    v: Array
    a: Array
    side: Array
    sample_times: Array

    @property
    def times(self) -> Array:
        return self.period * np.arange(len(self.q))

    @property
    def duration(self) -> float:
        return self.period * (len(self.q) - 1)


def motion(time: Array, q: Array, step: float, sided: bool = False) -> Motion:
    """Command from joints q (N, n) at times (N,) of the path, for an integrator of this step [s]."""
    length = float(time[-1] - time[0])
    ramp = min(RAMP, 0.4 * length)
    period = step / 2
    steps = int(np.ceil((LEAD + length + ramp + TRAIL) / step))
    t = period * np.arange(2 * steps + 1)
    phase, rate, change = _phase(t - LEAD, length, ramp)
    spline = CubicSpline(time - time[0], q, bc_type="natural" if len(time) > 2 else "not-a-knot")
    first, second = spline(phase, 1), spline(phase, 2)
    place, v = spline(phase), first * rate[:, None]
    a = second * rate[:, None] ** 2 + first * change[:, None]
    side = sides(place) if sided else np.zeros_like(place)
    return Motion(period, place, v, a, side, _instants(time - time[0], length, ramp) + LEAD)


def hold(q: Array, duration: float, step: float, side: Array | None = None) -> Motion:
    """Joints q (n,) commanded for a while, come to from `side` (n,)."""
    count = 2 * round(duration / step) + 1
    still = np.zeros((count, len(q)))
    from_side = still if side is None else still + side
    return Motion(step / 2, still + q, still, still, from_side, np.array([duration]))


def _phase(t: Array, length: float, ramp: float) -> tuple[Array, Array, Array]:
    """Path time, its rate and the rate's change at times t from the path's start."""
    end = length + ramp
    mirrored = t > end / 2
    u = np.clip(np.where(mirrored, end - t, t), 0.0, None)
    x = np.minimum(u / ramp, 1.0)
    way = ramp * x**4 * (2.5 + x * (x - 3.0)) + np.maximum(u - ramp, 0.0)
    rate = x**3 * (10.0 + x * (6.0 * x - 15.0))
    change = 30.0 * x**2 * (1.0 - x) ** 2 / ramp
    return (
        np.where(mirrored, length - way, way),
        rate,
        np.where(mirrored, -change, change),
    )


def _instants(time: Array, length: float, ramp: float) -> Array:
    """When the path times (N,) are reached, from the path's start."""
    fine = np.linspace(0.0, length + ramp, 20001)
    t = np.interp(time, _phase(fine, length, ramp)[0], fine)
    for _ in range(3):
        way, rate, _ = _phase(t, length, ramp)
        t = t - np.where(rate > 1e-3, (way - time) / np.maximum(rate, 1e-3), 0.0)
    return t


def sides(q: Array) -> Array:
    """(K, n) side of approach along joints q (K, n): goes over within `SETTLING` once a joint turns round."""
    step = np.diff(q, axis=0)
    keep, sign = np.exp(-np.abs(step) / SETTLING), np.sign(step)
    out = np.empty_like(q)
    moving = np.abs(q - q[0]) > 1e-6
    first = np.argmax(moving, axis=0)
    side = np.sign(q[first, np.arange(q.shape[1])] - q[0])
    out[0] = side
    for k in range(len(step)):
        side = sign[k] + (side - sign[k]) * keep[k]
        out[k + 1] = side
    return out
