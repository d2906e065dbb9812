"""What the controller knows of its robot: torques that the nominal arm needs, fed forward."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydrake.multibody.tree import MultibodyForces

from ...robot.compensator import compensator_law
from ...robot.description import Robot
from ...robot.kinematics import Array, frames
from ...robot.loads import Loads, wrenches
from ...robot.loop import Loop
from ...robot.rigid_plant import arrays
from .drives import rigid_machine
from .mechanics import Mechanics
from .motion import Motion, interpolated, slow_part

FEED_FORWARD_PERIOD = 0.004  # s between the instants at which the nominal robot's torques are computed


def feed_forward(nominal: Mechanics, motion: Motion, loop: Loop) -> Array:
    """(K, n) torques that the nominal arm needs at the motion's instants: weight, compensator, inertia.

    Of the command without what is faster than `feed_forward_hz`: the links need not follow a gear's ripple;
    the motor has to, and its own inertia is added to these torques for the whole command.
    """
    stride = max(1, round(FEED_FORWARD_PERIOD / motion.period))
    slow = slow_part(motion.q, loop.feed_forward_hz, motion.period)
    v = np.gradient(slow, motion.period, axis=0)
    a = np.gradient(v, motion.period, axis=0)
    at = np.unique(np.append(np.arange(0, len(slow), stride), len(slow) - 1))
    torque = static_torque(nominal, slow[at]) + inertial_torque(nominal, slow[at], v[at], a[at])
    return interpolated(np.arange(len(slow)), at, torque)


def static_torque(nominal: Mechanics, q: Array) -> Array:
    """(K, n) torques that hold the nominal, rigid arm against weight and compensator."""
    arm = nominal.arm
    count = len(q)
    loads = Loads(
        np.full(count, nominal.mass),
        np.tile(nominal.moment, (count, 1)),
        np.zeros((count, 6)),
        np.zeros((count, arm.n)),
        nominal.compensator,
    )
    local = wrenches(arm, frames(arm, q), loads).local
    return -arm.own(local)


def inertial_torque(nominal: Mechanics, q: Array, v: Array, a: Array) -> Array:
    """(K, n) torques that the nominal, rigid arm needs against its inertia."""
    plant, at = rigid_machine(nominal.arm, nominal.mass, nominal.moment)
    context = plant.CreateDefaultContext()
    none = MultibodyForces(plant)
    out = np.empty_like(q)
    x, acceleration = np.zeros(2 * len(at)), np.zeros(len(at))
    for k in range(len(q)):
        x[at], x[len(at) + at], acceleration[at] = q[k], v[k], a[k]
        plant.SetPositionsAndVelocities(context, x)
        out[k] = plant.CalcInverseDynamics(context, acceleration, none)[at]
    return out


def nominal_mechanics(robot: Robot, truth: Mechanics) -> Mechanics:
    """What the controller believes: the URDF, rigid, with the stated loads: nobody tells it what a diagnosis
    found of them."""
    arm, (mass, moment) = arrays(robot), truth.stated
    plain, law = arm.with_geometry(np.zeros_like(arm.geometry)), compensator_law(robot, arm)
    return replace(
        truth, robot=robot, arm=plain, mass=mass, moment=moment, compensator=law, gear=(), gives=()
    )
