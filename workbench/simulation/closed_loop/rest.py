"""Where the simulated arm stands before it runs: loaded, drives at their places."""

from __future__ import annotations

import numpy as np

from ...robot.equilibrium import NoRest
from ...robot.kinematics import Array
from .dynamics import Dynamics
from .gears import of_springs


def rest(dynamics: Dynamics, q: Array) -> Array:
    """Puts the arm, drives at q (n,), in its loaded equilibrium; the torques (n,) that hold it there.

    Drake's own torques: e ← δ + yield(torque) until it stands. Raises ArithmeticError where it finds none.
    """
    machine = dynamics.machine
    motors, springs, own = machine.motors, machine.springs, machine.own_at
    native = np.where(machine.native, machine.stiffness, 0.0)
    dynamics.put(q)
    errors, slope = dynamics.gears.errors(q.tolist(), dynamics.side)
    error, last = of_springs(machine, np.array(errors)), np.inf
    laws = [(machine.own[j], table) for j, table in dynamics.springs.tables.items()]
    extra = -dynamics.rubbing.wound
    if dynamics.along.torque is not None:
        extra = extra + dynamics.along.torque[0]
    dynamics.place(0)
    for _ in range(60):
        dynamics.set(dynamics.q, dynamics.v)
        torque = dynamics.drakes()
        if dynamics.bodies.active:
            torque += dynamics.bodies.at(0, None)
        torque[motors] += extra
        torque[own] += extra[machine.sprung]
        load = torque[springs] + native * dynamics.q[springs]
        if not len(load):
            break
        yields = load / machine.stiffness
        for i, (way, pulled) in laws:
            yields[i] = np.interp(load[i], pulled, way)
        new = error + yields
        change = float(np.abs(new - dynamics.q[springs]).max())
        dynamics.q[springs] = new
        if change < 1e-14 or (change < 1e-10 and change > 0.5 * last):  # as still as rounding allows
            break
        last = change
    else:
        raise NoRest
    needed = -torque[motors]
    if dynamics.springs.reaction:
        for one in dynamics.springs.erring:
            for pair, _ in one.pairs:
                needed[dynamics.gears.curves[pair].by] -= slope[pair] * load[machine.own[one.joint]]
    return np.asarray(needed)
