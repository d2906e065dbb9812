"""The sampled controller: a position loop, a velocity loop (PI) below it, a hold, a delay.

Every drive period the encoder is read, its steps counted, the velocity taken from the last two readings and
filtered, and a torque computed that acts `delay` later and is held for a drive period. Every position period
the position's error sets a correction of the velocity, held until the next. The command comes at the position
period and is interpolated between by a cubic in position and velocity. Set-points are compared with what
was measured at the same instant: the filter's lag is known, and so is the delay of the feed-forward.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, floor

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ...robot.kinematics import Array
from ...robot.loop import Loop
from .drives import Drives
from .friction import stribeck
from .motion import Motion, interpolated

TURNING = 0.05  # of the Stribeck speed: below which the friction fed forward turns round


@dataclass(frozen=True, eq=False)
class Gains:
    """Of n joints: velocity [N·m s], its integral [N·m], position [1/s]. asked: (n, 2) and reached: (n, 2)
    bandwidth of velocity and position loop [Hz]; notes: where less was reached than asked."""

    kp: Array
    ki: Array
    kv: Array
    asked: Array
    reached: Array
    notes: tuple[str, ...] = ()

    def times(self, factor: float) -> Gains:
        """All of them times a factor."""
        return replace(self, kp=factor * self.kp, ki=factor * self.ki, kv=factor * self.kv)

    def to_json(self) -> dict[str, list[float]]:
        """By their names, a number for each joint."""
        return {name: [float(f"{v:.5g}") for v in getattr(self, name)] for name in ("kp", "ki", "kv")}


@dataclass(eq=False)
class Cascade:
    """The feedback of n joints, on columns: every state is (n,), or (n, m) for m cases at once.

    before: encoders at the last reading; speed: as measured and filtered; integral: the velocity loop's
    torque; correction: of the velocity, by the position loop.
    """

    loop: Loop
    gains: Gains
    before: Array
    speed: Array
    integral: Array
    correction: Array

    def __post_init__(self) -> None:
        T = self.loop.drive_period
        self.share = T / (T + self.loop.velocity_filter)
        self.ki = self.gains.ki * T

    @classmethod
    def at_rest(cls, loop: Loop, gains: Gains, q: Array, integral: Array) -> Cascade:
        return cls(loop, gains, q, np.zeros_like(q), integral, np.zeros_like(q))

    def measure(self, seen: Array) -> None:
        """Reads encoders (n,): velocity by difference, filtered."""
        turned = (seen - self.before) / self.loop.drive_period
        self.speed = self.speed + self.share * (turned - self.speed)
        self.before = seen

    def correct(self, wanted: Array) -> None:
        """The position loop: from the position wanted now (n,)."""
        self.correction = _scaled(self.gains.kv, wanted - self.before)

    def torque(self, wanted: Array, feed: Array) -> tuple[Array, Array]:
        """Torque for the velocity wanted (n,) over the feed-forward (n,), and what the integral would
        become."""
        off = wanted - self.speed
        integral = self.integral + _scaled(self.ki, off)
        return feed + _scaled(self.gains.kp, off) + integral, integral


def _scaled(gain: Array, values: Array) -> Array:
    return np.asarray(gain * values if values.ndim == 1 else gain[:, None] * values)


@dataclass(frozen=True, eq=False)
class SetPoints:
    """What the controller is told, a row per drive period: position, velocity as the filter will show it,
    torque fed forward for when it will act."""

    q: Array
    v: Array
    feed: Array


def set_points(motion: Motion, torque: Array, drive: Drives, loop: Loop) -> SetPoints:
    """From the command and the nominal robot's torque (K, n) at its instants."""
    T = loop.drive_period
    count = int(np.ceil(motion.duration / T - 1e-9)) + 1
    t = np.asarray(T * np.arange(count), float)
    cycles = int(np.ceil((count - 1) / loop.cycles)) + 2
    coarse = np.asarray(loop.cycles * T * np.arange(cycles), float)
    curve = CubicHermiteSpline(
        coarse, interpolated(coarse, motion.times, motion.q), interpolated(coarse, motion.times, motion.v)
    )
    seen = t - T / 2 - loop.velocity_filter
    acts = t + loop.delay + T / 2
    v, a = curve(acts, 1), curve(acts, 2)
    dry = stribeck(v / loop.stribeck_speed, drive.coulomb, (loop.stiction - 1) * drive.coulomb)
    rubbing = dry * np.tanh(v / (TURNING * loop.stribeck_speed)) + drive.viscous * v
    feed = interpolated(acts, motion.times, torque) + drive.rotor * a + loop.friction_known * rubbing
    return SetPoints(curve(t), np.where(seen[:, None] < 0, 0.0, curve(np.maximum(seen, 0.0), 1)), feed)


@dataclass(frozen=True)
class Delay:
    """From a sample to its torque, in steps of an integration that has `parts` of them in a drive period.

    A step in which one torque takes over from another has both, each for its share of it."""

    steps: float
    parts: int

    @cached_property
    def kept(self) -> int:
        """Torques that are on their way."""
        return -(-ceil(self.steps - 1e-9) // self.parts)

    @cached_property
    def _late(self) -> tuple[int, float]:
        """Whole steps, and the share of one that is left."""
        late = floor(self.steps + 1e-9)
        return late, max(self.steps - late, 0.0)

    def acting(self, torques: Sequence[Array], i: int) -> Array:
        """The torque over the i-th step of a drive period. torques: `kept` that are on their way, oldest
        first, and the one sampled now."""
        late, share = self._late
        new = torques[self.kept + (i - late) // self.parts]
        if share < 1e-9:
            return new
        old = torques[self.kept + (i - late - 1) // self.parts]
        return new if old is new else share * old + (1 - share) * new
