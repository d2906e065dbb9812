"""Friction that remembers: a Dahl element, for what rubs, what winds up and what has play.

Its state s, −1 … 1, goes over to the sign of the motion along a short way c:  ds = (sgn dx − s) |dx| / c
(Dahl 1968). Along one step of dx that is exact:  s → sgn + (s − sgn) exp(−|dx| / c).
"""

from __future__ import annotations

import numpy as np

from ...robot.kinematics import Array
from ...robot.loop import Loop
from .drives import Drives
from .machine import Machine


class Rubbing:
    """Dry friction at the n drives, and behind their gears, where motor and spring move together.

    memory: (2 n,) the states; of_velocity: (2 n, V) the velocities that add up at each.
    """

    def __init__(self, machine: Machine, drive: Drives, loop: Loop, step: float) -> None:
        n, size = len(machine.motors), machine.plant.num_velocities()
        self.loop, self.h = loop, step
        self.of_velocity = np.zeros((2 * n, size))
        self.of_velocity[np.arange(2 * n), np.tile(machine.motors, 2)] = 1.0
        self.of_velocity[n + machine.sprung, machine.own_at] = 1.0
        self.on_places = self.of_velocity.T.copy()
        pairs = np.einsum("ki,kj->ijk", self.of_velocity, self.of_velocity).reshape(size**2, 2 * n)
        self.on_entries = step**2 / 2 / loop.presliding * pairs
        self.ways = 1 / loop.presliding * self.of_velocity
        self.scaled = np.concatenate([step * self.ways, self.of_velocity / loop.stribeck_speed])
        self.dry = np.concatenate([(1 - loop.load_side) * drive.coulomb, loop.load_side * drive.coulomb])
        self.more = (loop.stiction - 1) * self.dry
        self.active = bool(self.dry.any())
        self.memory = np.zeros(2 * n)

    @property
    def wound(self) -> Array:
        """(n,) what friction behind the gears holds at rest [N·m, N]."""
        n = len(self.dry) // 2
        return np.asarray(self.dry[n:] * self.loop.stiction * self.memory[n:])

    def take(self, v: Array, force: Array) -> Array:
        """Takes its mean over a step at velocities v (V,) off the force (V,); how that falls with the
        velocities' change: (V, V).

        It is linearised about the way that the step before makes likely, whose slope by Δv is h/2, not h/4
        as a spring's: twice as soft.
        """
        scaled = self.scaled @ v
        mean, slope = mean_on_the_way(self.memory, scaled[: len(self.dry)])
        rubs = stribeck(scaled[len(self.dry) :], self.dry, self.more)
        force -= self.on_places @ (rubs * mean)
        return np.asarray(self.on_entries @ (rubs * slope)).reshape(len(v), len(v))

    def go(self, moved: Array) -> None:
        """Remembers a motion (V,)."""
        self.memory = gone_over(self.memory, self.ways @ moved)


def gone_over(s: Array, dx: Array) -> Array:
    """States after motions dx, in ways over which friction builds up, from states s."""
    sign = np.sign(dx)
    return np.asarray(sign + (s - sign) * np.exp(-np.abs(dx)))


def mean_on_the_way(s: Array, dx: Array) -> tuple[Array, Array]:
    """Means of the states along motions dx as above, and how steeply they go with dx; none is negative."""
    sign = np.sign(dx)
    a = np.abs(dx) + 1e-4
    left = np.exp(-a)
    share = (1 - left) / a
    return sign + (s - sign) * share, (sign * s - 1) * (left - share) / a


def stribeck(v: Array, dry: Array, more: Array) -> Array:
    """Size of dry friction [N·m, N] at speeds v over the Stribeck speed: `dry`, and `more` at rest."""
    return np.asarray(dry + more * np.exp(-np.square(v)))
