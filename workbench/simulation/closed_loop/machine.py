"""The simulated robot as a Drake plant: drives, springs, links, payload, compensator.

Springs that are linear are Drake's force elements, and so is a compensator's coil; a gas is a
`Cylinder` at the plant's port. The springs' joints carry no inertia of their own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, PrismaticJoint, RevoluteJoint
from pydrake.systems.framework import Diagram

from ...robot.force_systems import Cylinder
from ...robot.kinematics import Arm, Array
from ...robot.plant_diagram import cylinder_of, plant_diagram
from ...robot.plant_parts import add_rotor, add_spring, axial_joint, point_inertia, screw_joint
from ...robot.plants import ArmPlant, arm_plant, rigid_arm_plant
from .mechanics import Mechanics, Screw


@dataclass(frozen=True, eq=False)
class Machine:
    """The plant and where things are in it. n joints, K springs: first the joints' own, then the screws.

    motors: (n,), springs: (K,) places in positions and velocities; own: (n,) place among the springs of
    each joint's own spring, −1 for none. stiffness: (K,) [N·m/rad, N/m]; native: (K,) whether the spring is
    Drake's force element. rotor: (n,) reflected inertia of the drives [kg·m², kg]. diagram: the plant
    with what acts at its ports; cylinder: the compensator there, None where there is none or it is a coil.
    """

    built: ArmPlant
    motors: NDArray[np.int64]
    springs: NDArray[np.int64]
    own: NDArray[np.int64]
    stiffness: Array
    native: NDArray[np.bool_]
    rotor: Array
    diagram: Diagram
    cylinder: Cylinder | None

    @property
    def plant(self) -> MultibodyPlant:
        return self.built.plant

    @cached_property
    def sprung(self) -> NDArray[np.int64]:
        """Joints that have a spring of their own, in the springs' order."""
        return np.flatnonzero(self.own >= 0)

    @cached_property
    def own_at(self) -> NDArray[np.int64]:
        """Places of the joints' own springs, in the springs' order."""
        return self.springs[: len(self.sprung)]

    @property
    def flange(self) -> Frame:
        """The frame that carries the tool."""
        return self.built.slots[-1]


def machine(mechanics: Mechanics, rotor: Array) -> Machine:
    """Builds the plant. rotor: (n,) reflected inertia of each drive [kg·m², kg]."""
    moving = _Moving(mechanics, rotor)
    built = arm_plant(
        mechanics.arm,
        moving.at_slot,
        point_inertia(mechanics.mass, mechanics.moment),
        mechanics.placed[0],
        mechanics.compensator,
    )
    cylinder = cylinder_of(built, mechanics.arm, mechanics.compensator)
    springs = [joint.position_start() for joint in (*moving.own, *moving.screws)]
    own = np.full(mechanics.arm.n, -1)
    own[moving.sprung] = np.arange(len(moving.own))
    stiffness = [law.stiffest for law in mechanics.axial if law is not None]
    stiffness += [1 / screw.compliance for screw in moving.order]
    return Machine(
        built,
        np.array([joint.position_start() for joint in moving.motors]),
        np.array(springs, dtype=np.int64),
        own,
        np.array(stiffness),
        np.array(moving.native, dtype=bool),
        np.asarray(rotor, float),
        plant_diagram(built.plant, None, cylinder),
        cylinder,
    )


def mass_matrix(built: Machine, q: Array) -> Array:
    """(V, V) with the drives at joints q (n,) and the springs slack."""
    context = built.plant.CreateDefaultContext()
    place = np.zeros(built.plant.num_positions())
    place[built.motors] = q
    built.plant.SetPositions(context, place)
    return np.asarray(built.plant.CalcMassMatrix(context))


def modes(built: Machine, q: Array) -> Array:
    """(K,) natural frequencies [rad/s] of the arm on its springs, drives locked at joints q (n,),
    ascending."""
    M = mass_matrix(built, q)[np.ix_(built.springs, built.springs)]
    scale = 1 / np.sqrt(built.stiffness)
    slowness = np.maximum(np.linalg.eigvalsh(scale[:, None] * M * scale), 1e-12)
    return np.asarray(1 / np.sqrt(slowness[::-1]))


def rigid_machine(arm: Arm, mass: float, moment: Array) -> tuple[MultibodyPlant, NDArray[np.int64]]:
    """The arm without springs, drives and gravity, and its joints' places: for feed-forward."""
    plant = rigid_arm_plant(replace(arm, gravity=np.zeros(3)), point_inertia(mass, moment)).plant
    return plant, np.array([plant.GetJointByName(name).position_start() for name in arm.names])


class _Moving:
    """What moves at the slots: screws, then drive and spring; and which joint is which."""

    def __init__(self, mechanics: Mechanics, rotor: Array) -> None:
        self.mechanics, self.rotor = mechanics, rotor
        self.motors: list[Joint] = []
        self.own: list[Joint] = []
        self.sprung: list[int] = []
        self.screws: list[Joint] = []
        self.order: list[Screw] = []
        self.of_joints: list[bool] = []
        self.of_screws: list[bool] = []

    @property
    def native(self) -> list[bool]:
        return [*self.of_joints, *self.of_screws]

    def at_slot(self, plant: MultibodyPlant, slot: int, frame: Frame) -> Frame:
        for screw in self.mechanics.screws:
            if screw.slot == slot:
                frame = self._screw(plant, screw, frame)
        return self._drive(plant, slot, frame) if 1 <= slot <= self.mechanics.arm.n else frame

    def _screw(self, plant: MultibodyPlant, screw: Screw, frame: Frame) -> Frame:
        pitch = None if screw.shift else screw.pitch
        joint = screw_joint(plant, f"screw_{len(self.screws)}", frame, screw.axis, screw.point, pitch)
        self.of_screws.append(_sprung(plant, joint, 1 / screw.compliance))
        self.screws.append(joint)
        self.order.append(screw)
        return joint.child_body().body_frame()

    def _drive(self, plant: MultibodyPlant, slot: int, frame: Frame) -> Frame:
        arm, j = self.mechanics.arm, slot - 1
        motor = axial_joint(plant, arm, slot, f"{arm.names[j]}_motor", frame)
        add_rotor(plant, motor, float(self.rotor[j]))
        self.motors.append(motor)
        if (law := self.mechanics.axial[j]) is None:
            return motor.child_body().body_frame()
        spring = axial_joint(plant, arm, slot, f"{arm.names[j]}_spring", motor.child_body().body_frame())
        self.of_joints.append(law.torque is None and _sprung(plant, spring, law.stiffest))
        self.own.append(spring)
        self.sprung.append(j)
        return spring.child_body().body_frame()


def _sprung(plant: MultibodyPlant, joint: Joint, stiffness: float) -> bool:
    """Whether Drake has a spring for such a joint; it is there then."""
    if not isinstance(joint, RevoluteJoint | PrismaticJoint):
        return False
    add_spring(plant, joint, stiffness)
    return True
