"""What is commanded, over time: the path's joints as smooth motion from rest to rest.

Joints run through the samples of the command as a cubic spline, which ends at corners. The path's own time is
slowed at both ends by a quintic ramp, so that the arm starts and ends at rest. As controllers do, a filter
over a few milliseconds bounds the jerk, where a command steps or turns sharply; its kernel has no second
moment, so curves are not cut.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PPoly
from scipy.ndimage import gaussian_filter1d

from ...robot.kinematics import Array

LEAD = 0.1  # s of rest before the path
TRAIL = 0.05
RAMP = 0.5
FILTER = 0.006  # s
PERIOD = 2.5e-4  # s: of the tables, half of the finest step
NO_CORNERS = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Motion:
    """Commanded joints at K instants, `period` apart: q, v, a (K, n) [rad, m, s].

    sample_times: (N,) [s] when the path's samples are passed. side: (n,) from which each came, −1 … 1.
    """

    period: float
    q: Array
    v: Array
    a: Array
    side: Array
    sample_times: Array

    @property
    def times(self) -> Array:
        return np.asarray(self.period * np.arange(len(self.q)), float)

    @property
    def duration(self) -> float:
        return self.period * (len(self.q) - 1)

    def ahead(self, t: Array, lead: Array) -> Motion:
        """The same with the drives ahead by a lead (J, n) at instants t (J,) [s]."""
        curve, times = CubicSpline(t, lead, bc_type="natural"), self.times
        return replace(self, q=self.q + curve(times), v=self.v + curve(times, 1), a=self.a + curve(times, 2))


def curve(time: Array, q: Array, corners: NDArray[np.int64]) -> PPoly:
    """Joints (…, n) over the path's time, from those q (N, n) at times (N,): cubic splines from corner to
    corner (C,)."""
    ends = [0, *corners.tolist(), len(time) - 1]
    parts = [
        CubicSpline(time[a : b + 1], q[a : b + 1], bc_type="natural" if b > a + 1 else "not-a-knot")
        for a, b in pairwise(ends)
    ]
    order = max(len(part.c) for part in parts)
    c = [np.concatenate([np.zeros((order - len(part.c), *part.c.shape[1:])), part.c]) for part in parts]
    return PPoly(np.concatenate(c, axis=1), time)


def motion(time: Array, q: Array, sided: bool = False, corners: NDArray[np.int64] = NO_CORNERS) -> Motion:
    """Command from joints q (N, n) at times (N,) of the path. sided: the side of approach matters; corners:
    samples (C,) in which the way turns off at once."""
    length = float(time[-1] - time[0])
    ramp = min(RAMP, 0.4 * length)
    steps = int(np.ceil((LEAD + length + ramp + TRAIL) / (4 * PERIOD)))
    t = np.asarray(PERIOD * np.arange(4 * steps + 1), float)
    phase, rate, change = _phase(t - LEAD, length, ramp)
    way = curve(time - time[0], q, corners)
    first = way(phase, 1)
    place, v = way(phase), _filtered(first * rate[:, None])
    side = first_sides(place) if sided else np.zeros(place.shape[1])
    if len(corners):  # where the velocity steps
        a = np.gradient(v, PERIOD, axis=0)
    else:
        a = _filtered(way(phase, 2) * rate[:, None] ** 2 + first * change[:, None])
    place = _filtered(place)
    return Motion(PERIOD, place, v, a, side, _instants(time - time[0], length, ramp) + LEAD)


def slow_part(x: Array, frequency_hz: float, period: float) -> Array:
    """x (K, n), `period` [s] apart, without what is faster than a frequency."""
    width = 1 / (2 * np.pi * frequency_hz) / period
    return np.asarray(gaussian_filter1d(x, width, axis=0, mode="nearest"))


def path_speed(p: Array, time: Array) -> float:
    """[m/s] tool speed that 95 % of the legs between places p (N, 3) [m] at times (N,) [s] keep to."""
    return float(np.quantile(np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(time), 0.95))


def _filtered(x: Array) -> Array:
    """x (K, n) through a symmetric filter that leaves parabolas as they are."""
    width = FILTER / PERIOD
    one = gaussian_filter1d(x, width, axis=0, mode="nearest")
    return np.asarray(2 * one - gaussian_filter1d(x, np.sqrt(2) * width, axis=0, mode="nearest"))


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


def interpolated(at: Array, times: Array, values: Array) -> Array:
    """Values (K, m) at instants `at` (K,), straight between those (N, m) at `times` (N,)."""
    return np.stack([np.interp(at, times, column) for column in values.T], axis=1)


def first_sides(q: Array) -> Array:
    """(n,) sides from which joints (K, n) are taken to have come: the ones to which they go first."""
    moving = np.abs(q - q[0]) > 1e-6
    first = np.argmax(moving, axis=0)
    return np.asarray(np.sign(q[first, np.arange(q.shape[1])] - q[0]))
