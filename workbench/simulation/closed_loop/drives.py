"""The drives: reflected inertia, friction, damping and limits of each joint; what is not stated is
assumed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant

from ...robot.kinematics import Arm, Array
from ...robot.loop import Loop
from ...robot.plant_parts import point_inertia
from ...robot.plants import rigid_arm_plant
from ...robot.schema import STANDARD_GRAVITY
from .mechanics import Mechanics

TURNS = 100.0  # of a motor per joint turn, where no gear ratio is stated


@dataclass(frozen=True, eq=False)
class Drives:
    """The drives of n joints as the simulation has them; torques on the joint's side [N·m, N].

    rotor: reflected inertia; arm: inertia that each joint moves, the others at rest; coulomb, viscous:
    friction; damping: of each spring; count: joint motion per encoder step (0: fine); torque, speed: limits.
    guessed: (n,) whose inertia is assumed. assumed: what of rotors and dampers is not stated; notes: that,
    and the friction.
    """

    rotor: Array
    arm: Array
    coulomb: Array
    viscous: Array
    damping: Array
    count: Array
    torque: Array
    speed: Array
    guessed: NDArray[np.bool_]
    assumed: tuple[str, ...]
    notes: tuple[str, ...]


def drives(mechanics: Mechanics, q: Array, loop: Loop) -> Drives:
    """The drives of a robot near joints q (n,). What the TOML does not say is assumed, and noted."""
    robot, arm = mechanics.robot, mechanics.arm
    inertia, mass = _felt(mechanics, q)
    stated = [j.data.rotor_inertia * (j.data.gear_ratio or 0.0) ** 2 for j in robot.joints]
    guessed = np.array(stated) <= 0
    rotor = np.where(guessed, 0.5 * inertia, stated)
    assumed = []
    if guessed.any():
        names = ", ".join(arm.names[j] for j in np.flatnonzero(guessed))
        assumed.append(f"{names}: drive's inertia not stated, taken as half of the arm's that it moves")
    scale = STANDARD_GRAVITY * np.where(arm.prismatic, mass, np.sqrt(inertia * mass))
    friction = (
        f"friction: {100 * loop.coulomb:g} % of the weight of the arm, stretched as the path starts, as "
        f"Coulomb, {100 * loop.viscous:g} % at 1 rad/s as viscous, {100 * loop.load_side:g} % of it behind "
        "the gear"
    )
    stiffness = np.array([law.stiffest if law else 0.0 for law in mechanics.axial])
    given = np.array([joint.data.damping for joint in robot.joints])
    if not given.all():
        names = ", ".join(n for n, value in zip(arm.names, given, strict=True) if not value)
        assumed.append(f"{names}: damping not stated, taken as 2 % of critical")
    turns = np.array([abs(j.data.gear_ratio or TURNS) for j in robot.joints])
    return Drives(
        rotor,
        inertia,
        loop.coulomb * scale,
        loop.viscous * scale,
        np.where(given > 0, given, 0.04 * np.sqrt(stiffness * inertia)),
        2 * np.pi / (turns * loop.encoder_steps) if loop.encoder_steps else np.zeros(arm.n),
        np.array([joint.effort for joint in robot.joints]),
        np.array([joint.velocity for joint in robot.joints]),
        guessed,
        tuple(assumed),
        (*assumed, friction),
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


def rigid_machine(arm: Arm, mass: float, moment: Array) -> tuple[MultibodyPlant, NDArray[np.int64]]:
    """The arm without springs, drives and gravity, and its joints' places: for feed-forward."""
    plant = rigid_arm_plant(replace(arm, gravity=np.zeros(3)), point_inertia(mass, moment)).plant
    return plant, np.array([plant.GetJointByName(name).position_start() for name in arm.names])
