"""Feed-forward of the elastic deflection: drives lead by what the arm will yield under its own inertia.

The tool's path is a flat output of an arm with elastic joints: along a wanted motion of the links the loads
on every spring are known, inertia included, and with them how far each drive has to be ahead (Spong 1987; De
Luca 2000). The static correction has the weight's part already; this adds the inertia's, for all that yields,
bearings and links too: q + J⁺ (tool's motion under the inertial wrenches).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...correction.conditions import Conditions
from ...correction.paths import Path
from ...correction.trajectory import trajectory_of
from ...robot.description import Robot
from ...robot.kinematics import Arm, Array, Frames, frames
from ...robot.loads import Loads
from ...robot.loop import Loop
from ...robot.rotations import cross
from .motion import Motion, interpolated, slow_part

PERIOD = 0.004  # s between the instants at which the deflection is computed


def with_elastic_lead(
    moved: Motion, belief: Robot, path: Path, q: Array, conditions: Conditions, tool: Array | None, loop: Loop
) -> Motion:
    """The motion with the drives ahead by the deflection that `belief` yields under its inertia.

    path: its N samples, at which `moved` passes the joints q (N, n).
    """
    t = np.append(np.arange(0.0, moved.duration, PERIOD), moved.duration)
    joints = interpolated(t, moved.times, moved.q)
    # twice as far as the torques: what is fed forward here does not drive a mode
    slow = slow_part(joints, 2 * loop.feed_forward_hz, PERIOD)
    at = _nearest(t, moved)
    trajectory = trajectory_of(belief, replace(path, q=q, X=None), conditions, tool)
    extended = trajectory.extended
    here = extended.at(slow, None, at)
    arm, loads = extended.loads(here)
    direct = extended.direct(here)
    where = frames(arm, slow, direct)
    law = extended.acting.yielding(arm).motion
    weight = extended.wrenches(here, where).local
    yields = law(weight + inertial_wrenches(arm, where, loads, t)) - law(weight)
    tip, nominal = trajectory.tip, trajectory.nominal
    moved_by = tip.error(frames(arm, slow, direct + yields), tip.pose(where))
    gain = tip.gain(nominal, tip.jacobian(nominal, frames(nominal, slow)))
    return moved.ahead(t, np.einsum("kij,kj->ki", gain, tip.scaled(moved_by)))


def _nearest(t: Array, moved: Motion) -> NDArray[np.int64]:
    """Number of the path's sample that is next to each instant (K,)."""
    return np.asarray(np.rint(np.interp(t, moved.sample_times, np.arange(len(moved.sample_times)))), np.int64)


def inertial_wrenches(arm: Arm, where: Frames, loads: Loads, t: Array) -> Array:
    """(K, S, 6) wrenches [N, N·m] at the slots, on their axes, of the inertia of all beyond them, along a
    motion whose frames are known at K instants t [s] (d'Alembert)."""
    slots = arm.slots
    force, moment = np.zeros((slots, len(t), 3)), np.zeros((slots, len(t), 3))
    for k in range(slots - 1, 0, -1):
        if k == slots - 1:
            mass, first, inertia = loads.mass, loads.moment, None
        else:
            mass = np.full(len(t), arm.mass[k])
            first, inertia = np.tile(arm.moment[k], (len(t), 1)), arm.inertia[k]
        if k < slots - 1:
            force[k], moment[k] = force[k + 1], moment[k + 1]
        heavy = mass > 0
        com = np.where(heavy[:, None], first / np.where(heavy, mass, 1.0)[:, None], 0.0)
        place = where.p[k] + np.einsum("kij,kj->ki", where.R[k], com)
        push = -mass[:, None] * _slope(_slope(place, t), t)
        force[k] = force[k] + push
        moment[k] = moment[k] + cross(place, push)
        if inertia is not None and mass[0] > 0:
            central = inertia - mass[0] * (com[0] @ com[0] * np.eye(3) - np.outer(com[0], com[0]))
            turned = where.R[k] @ central @ where.R[k].swapaxes(1, 2)
            moment[k] -= _slope(np.einsum("kij,kj->ki", turned, _turning(where.R[k], t)), t)
    about = moment.transpose(1, 0, 2) - cross(where.origin, force.transpose(1, 0, 2))
    local = np.empty((len(t), slots, 6))
    np.einsum("nsci,sni->nsc", where.axes[:, :, :3], force, out=local[..., :3])
    np.einsum("nsci,nsi->nsc", where.axes[:, :, 3:], about, out=local[..., 3:])
    return local


def _slope(values: Array, t: Array) -> Array:
    return np.asarray(np.gradient(values, t, axis=0))


def _turning(R: Array, t: Array) -> Array:
    """(K, 3) angular velocities [rad/s] of rotations R (K, 3, 3)."""
    W = _slope(R, t) @ R.swapaxes(1, 2)
    return np.stack([W[:, 2, 1] - W[:, 1, 2], W[:, 0, 2] - W[:, 2, 0], W[:, 1, 0] - W[:, 0, 1]], axis=1) / 2
