"""The joint controller: position and velocity loops in cascade on the motor's encoder, with feed-forward.

Gains follow from bandwidth. The velocity loop is sized for the drive alone (that is what the motor feels
above the arm's first mode), the position loop below the velocity loop with the whole arm on it, the integral
below both and so weak that it does not feed the arm's slowest mode. Feed-forward is what the nominal robot
needs: the arm's weight and inertia (of the command without what is faster than `bandwidth_hz`: the links
need not follow a gear's ripple, the motor has to), the drive's own inertia, and most of the friction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from pydrake.multibody.tree import MultibodyForces
from scipy.ndimage import gaussian_filter1d

from ...robot.compensator import compensator_law
from ...robot.description import Robot
from ...robot.kinematics import Array, frames
from ...robot.loads import Loads, wrenches
from ...robot.rigid_plant import arrays
from ...robot.schema import STANDARD_GRAVITY
from .machine import machine, rigid_machine, slowest_mode
from .mechanics import Mechanics
from .motion import Motion, interpolated

FEED_FORWARD_PERIOD = 0.004  # s between the instants at which the nominal robot's torques are computed
MOST_FRICTION = 300.0  # 1/s: slope of friction over the drive's inertia that a step of 1 ms bears


@dataclass(frozen=True)
class Controller:
    """velocity: of the inner loop with the drive alone [rad/s]; position: of the outer loop [rad/s];
    bandwidth_hz: of the feed-forward of the arm's inertia. friction_known: share of the friction that is
    fed forward. resolution: encoder steps per motor turn (None: fine)."""

    velocity: float = 1200.0
    position: float = 30.0
    bandwidth_hz: float = 10.0
    friction_known: float = 0.9
    resolution: float | None = None


@dataclass(frozen=True, eq=False)
class Drives:
    """The drives of n joints as the simulation has them; torques on the joint's side [N·m, N].

    rotor: reflected inertia; coulomb, viscous: friction, smooth below the speed `sliding`;
    damping: (n,) of each spring; kp, ki, kv: gains of velocity, its integral, position. count: (n,)
    joint motion per encoder step (0: fine).
    """

    rotor: Array
    coulomb: Array
    viscous: Array
    sliding: Array
    damping: Array
    kp: Array
    ki: Array
    kv: Array
    count: Array
    notes: tuple[str, ...]


def drives(mechanics: Mechanics, q: Array, controller: Controller) -> Drives:
    """Drives and gains for a robot near joints q (n,). What the TOML does not say is assumed, and noted."""
    robot, arm = mechanics.robot, mechanics.arm
    inertia, mass = _felt(mechanics, q)
    stated = [j.data.rotor_inertia * (j.data.gear_ratio or 0.0) ** 2 for j in robot.joints]
    rotor = np.where(np.array(stated) > 0, stated, 0.5 * inertia)
    notes = []
    if not all(stated):
        names = ", ".join(n for n, value in zip(arm.names, stated, strict=True) if not value)
        notes.append(f"{names}: drive's inertia not stated, taken as half of the arm's that it moves")
    # friction of a hundredth of what the arm would weigh, stretched out
    scale = STANDARD_GRAVITY * np.where(arm.prismatic, mass, np.sqrt(inertia * mass))
    coulomb = 0.01 * scale
    notes.append(
        "friction assumed: 1 % of the weight of the stretched arm, as Coulomb and, at 1 rad/s, viscous"
    )
    stiffness = np.array([law.stiffest if law else 0.0 for law in mechanics.axial])
    given = np.array([joint.data.damping for joint in robot.joints])
    damping = np.where(given > 0, given, 0.04 * np.sqrt(stiffness * inertia))
    if not given.all():
        notes.append("damping of joints assumed where not stated: 2 % of critical")
    kp = controller.velocity * rotor
    whole = kp / (inertia + rotor)  # the velocity loop's bandwidth with the whole arm on it
    kv = np.minimum(controller.position, 0.7 * whole)
    slowest = slowest_mode(machine(mechanics, rotor), q)
    turns = np.array([abs(j.data.gear_ratio or 100.0) for j in robot.joints])
    count = 2 * np.pi / (turns * controller.resolution) if controller.resolution else np.zeros(arm.n)
    return Drives(
        rotor,
        coulomb,
        0.01 * scale,
        coulomb / (MOST_FRICTION * rotor),
        np.minimum(damping, 1e-3 * stiffness),
        kp,
        kp * np.minimum(np.minimum(kv, whole / 3), slowest**2 / (4 * kv)),
        kv,
        count,
        tuple(notes),
    )


def _felt(mechanics: Mechanics, q: Array) -> tuple[Array, Array]:
    """Inertia (n,) that each joint moves, the others at rest, and mass (n,) beyond it."""
    arm = mechanics.arm
    plant, at = rigid_machine(arm, mechanics.mass, mechanics.moment)
    context = plant.CreateDefaultContext()
    place = np.zeros(plant.num_positions())
    place[at] = q
    plant.SetPositions(context, place)
    inertia = np.diag(plant.CalcMassMatrix(context))[at]
    beyond = np.array([arm.mass[k:].sum() for k in range(1, arm.n + 1)]) + mechanics.mass
    floor = 1e-3 * max(float(beyond[0]), 1.0)
    return np.maximum(inertia, floor), np.maximum(beyond, 0.1)


def feed_forward(nominal: Mechanics, motion: Motion, controller: Controller, drive: Drives) -> Array:
    """(K, n) torques that the nominal robot needs for the motion."""
    stride = max(1, round(FEED_FORWARD_PERIOD / motion.period))
    slow = gaussian_filter1d(
        motion.q, 1 / (2 * np.pi * controller.bandwidth_hz) / motion.period, axis=0, mode="nearest"
    )
    v = np.gradient(slow, motion.period, axis=0)
    a = np.gradient(v, motion.period, axis=0)
    at = np.unique(np.append(np.arange(0, len(slow), stride), len(slow) - 1))
    torque = static_torque(nominal, slow[at]) + _inertial(nominal, slow[at], v[at], a[at])
    smooth = interpolated(np.arange(len(slow)), at, torque)
    friction = drive.coulomb * np.tanh(motion.v / drive.sliding) + drive.viscous * motion.v
    return smooth + drive.rotor * motion.a + controller.friction_known * friction


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
    return -local.reshape(count, -1)[:, arm.axial]


def _inertial(nominal: Mechanics, q: Array, v: Array, a: Array) -> Array:
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
    """What the controller believes: the URDF, rigid, with the stated loads."""
    arm = arrays(robot)
    plain = arm.with_geometry(np.zeros_like(arm.geometry))
    return replace(truth, robot=robot, arm=plain, compensator=compensator_law(robot, arm), gear=(), screws=())
