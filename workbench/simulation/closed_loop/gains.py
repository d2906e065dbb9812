"""Gains from bandwidth and margin.

The velocity loop is sized for the drive alone, which is what a motor feels above the arm's first mode. What
hold, filter and delay take of its phase at the crossover, and the integral, leave the stated margin:
ω T + atan(ω_i/ω) = 90° − margin. Then the whole arm is put on it: the sampled loop, elastic arm and all
joints at once, has to stay stable with `gain_margin` times the gains and with `delay_margin` more delay,
where along the path each drive moves most and least inertia. Where it does not, the joint that moves most in
the least stable motion is slowed until it does. `gain_factor` comes last: drives that are tuned otherwise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...files.faults import Fault, InputError
from ...robot.kinematics import Array
from ...robot.loop import Loop
from .cascade import Cascade, Delay, Gains
from .drives import Drives
from .machine import Machine, machine, mass_matrix
from .mechanics import Mechanics

INTEGRAL = 0.2  # of the velocity loop's crossover: 11° of its phase
LOOKED = 60  # poses of a path
SLOWER = 0.85  # per round
ROUNDS = 120
FINE, FINEST = 4, 2.5e-4  # steps of the linear model in a drive period, at least; how long one may be [s]
UNMOVED = 1e-9  # of the largest: how little a drive moves that takes no part
STABLE = 1 - 1e-7  # largest size of an eigenvalue over a position period


def crossover(loop: Loop) -> float:
    """[rad/s] of the velocity loop on the drive alone, that leaves the phase margin."""
    lag = loop.drive_period + loop.velocity_filter + loop.delay  # half a period to hold, half to difference
    return float((np.pi / 2 - np.radians(loop.phase_margin_deg) - np.arctan(INTEGRAL)) / lag)


def gains(mechanics: Mechanics, drive: Drives, loop: Loop, q: Array) -> Gains:
    """Gains that are stable with their margins along joints q (N, n). Raises InputError where none are."""
    most = crossover(loop)
    n = mechanics.arm.n
    asked = np.full((n, 2), 2 * np.pi * loop.position_hz)
    asked[:, 0] = most if loop.velocity_hz is None else 2 * np.pi * loop.velocity_hz
    if most <= 0:
        raise ValueError("no phase is left for a velocity loop")
    scale = np.ones(n)
    built = machine(mechanics, drive)
    poses, felt = _extremes(built, q)
    models = [_Linear(built, drive, loop, pose) for pose in poses]
    drive = replace(drive, arm=np.maximum(drive.arm, felt - drive.rotor))
    for _ in range(ROUNDS):
        found = _at(loop, drive, asked, most, scale)
        worst = _least_stable(models, found, loop)
        if worst is None:
            break
        scale[worst] *= SLOWER
    else:
        what = "no gains are stable with the margins and bandwidths asked"
        raise InputError(Fault("[controller.loop]", what, "ask for other ones: position_hz, velocity_hz"))
    told = found.times(loop.gain_factor)
    if loop.gain_factor != 1 and any(model.least_stable(told, 1.0, 0.0)[0] > STABLE for model in models):
        what = f"of {loop.gain_factor:g} leaves no stable loop"
        raise InputError(Fault("[controller.loop] gain_factor", what, "take one nearer to 1"))
    return replace(told, notes=_notes(mechanics, found))


def _extremes(built: Machine, q: Array) -> tuple[Array, Array]:
    """Joints (P, n) where a drive moves most and least inertia, of `LOOKED` at along joints q (N, n), and the
    most (n,)."""
    some = q[np.unique(np.linspace(0, len(q) - 1, LOOKED).round().astype(int))]
    felt = np.array([np.diag(mass_matrix(built, pose))[built.motors] for pose in some])
    return some[np.unique([felt.argmax(axis=0), felt.argmin(axis=0)])], felt.max(axis=0)


def _at(loop: Loop, drive: Drives, asked: Array, most: float, scale: Array) -> Gains:
    velocity = np.minimum(asked[:, 0], most) * scale
    whole = velocity * drive.rotor / (drive.rotor + drive.arm)  # with the whole arm on it
    position = np.minimum(asked[:, 1], whole / 2)
    kp = velocity * drive.rotor
    ki = kp * np.minimum(INTEGRAL * velocity, position)
    reached = np.stack([velocity, position], axis=1) / (2 * np.pi)
    return Gains(kp, ki, position, asked / (2 * np.pi), reached)


def _least_stable(models: list[_Linear], gains: Gains, loop: Loop) -> int | None:
    """The joint that moves most in a motion that does not die out; None when all do."""
    cases = ((1.0, 0.0), (loop.gain_margin, 0.0), (1.0, loop.delay_margin))
    for model in models:
        for factor, later in cases:
            radius, joint = model.least_stable(gains, factor, later)
            if radius > STABLE:
                return joint
    return None


def _notes(mechanics: Mechanics, found: Gains) -> tuple[str, ...]:
    out = []
    for what, column in (("velocity", 0), ("position", 1)):
        asked, reached = found.asked[:, column], found.reached[:, column]
        less = np.flatnonzero(reached < 0.99 * asked)
        if len(less):
            said = ", ".join(f"{mechanics.arm.names[j]} {reached[j]:.2g}" for j in less)
            out.append(f"{what} loop: {asked[0]:.3g} Hz asked, its margins allow {said} Hz")
    return tuple(out)


class _Linear:
    """The robot about a pose, sampled finely, and the loop around it."""

    def __init__(self, built: Machine, drive: Drives, loop: Loop, q: Array) -> None:
        self.loop, self.n = loop, len(q)
        self.parts = max(FINE, int(np.ceil(loop.drive_period / FINEST - 1e-9)))
        h = self.h = loop.drive_period / self.parts
        M = mass_matrix(built, q)
        size = len(M)
        K, D = np.zeros(size), np.zeros(size)
        K[built.springs] = built.stiffness
        D[built.springs] = built.damping
        D[built.motors] = drive.viscous
        inverse = np.linalg.inv(M + np.diag(h / 2 * D + h**2 / 4 * K))
        dv_q, dv_v = -h * inverse * K, -inverse * (h * D + h**2 / 2 * K)
        one = np.eye(size)
        self.free = np.block([[one + h / 2 * dv_q, h * one + h / 2 * dv_v], [dv_q, one + dv_v]])
        dv_u = h * inverse[:, built.motors]
        self.driven = np.concatenate([h / 2 * dv_u, dv_u])
        self.motors, self.size = built.motors, size

    def least_stable(self, gains: Gains, factor: float, later: float) -> tuple[float, int]:
        """Size of the largest eigenvalue over a position period, and the joint that moves most in it."""
        loop, n = self.loop, self.n
        delay = Delay((loop.delay + later) / self.h, self.parts)
        states = 2 * self.size + (4 + delay.kept) * n
        Z = np.eye(states)
        x = Z[: 2 * self.size]
        rest = [Z[2 * self.size + k * n : 2 * self.size + (k + 1) * n] for k in range(4 + delay.kept)]
        cascade = Cascade(loop, gains, *rest[:4])
        waiting = rest[4:]  # oldest first
        none = np.zeros((n, states))
        for tick in range(loop.cycles):
            cascade.measure(x[self.motors])
            if tick == 0:
                cascade.correct(none)
            torque, cascade.integral = cascade.torque(cascade.correction, none)
            waiting = [*waiting, factor * torque]
            for i in range(self.parts):
                x = self.free @ x + self.driven @ delay.acting(waiting, i)
            waiting = waiting[1:]
        parts = [x, cascade.before, cascade.speed, cascade.integral, cascade.correction, *waiting]
        values, vectors = np.linalg.eig(np.concatenate(parts))
        # a motion that no drive takes part in (of what yields without mass behind it) is not the loop's
        moving = np.abs(vectors[self.size + self.motors]) * gains.kp[:, None]
        radius = np.where(moving.max(axis=0) > UNMOVED * moving.max(), np.abs(values), 0.0)
        worst = int(np.argmax(radius))
        return float(radius[worst]), int(np.argmax(moving[:, worst]))
