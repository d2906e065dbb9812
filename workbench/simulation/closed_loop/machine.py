"""The simulated robot as a Drake plant: drives, springs, links, payload, compensator.

Springs that are linear are Drake's force elements with Drake's dampers, and so is a compensator's coil; a gas
is a `Cylinder` at the plant's port. The springs' joints carry no inertia of their own. Exports write this
plant down (`export/tree.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint

from ...robot.force_systems import Cylinder
from ...robot.kinematics import Array
from ...robot.plant_diagram import cylinder_of
from ...robot.plant_parts import add_rotor, add_spring, axial_joint, give_joint, point_inertia
from ...robot.plants import ArmPlant, arm_plant
from .drives import Drives
from .mechanics import Give, Mechanics

GIVE_DAMPING = 6e-4  # s: damping of a slot that gives way over its stiffness


@dataclass(frozen=True, eq=False)
class Machine:
    """The plant and where things are in it. n joints, K springs: first the joints' own, then how else slots
    give way.

    motors: (n,), springs: (K,) places in positions and velocities; names: of the springs' joints; own: (n,)
    place among the springs of each joint's own spring, −1 for none. stiffness: (K,) [N·m/rad, N/m]; damping:
    (K,) [N·m·s/rad, N·s/m]; native: (K,) whether the spring is Drake's force element.
    cylinder: the compensator, for the plant's port (`plant_diagram`); None where there is none or it is a
    coil.
    """

    built: ArmPlant
    motors: NDArray[np.int64]
    springs: NDArray[np.int64]
    names: tuple[str, ...]
    own: NDArray[np.int64]
    stiffness: Array
    damping: Array
    native: NDArray[np.bool_]
    cylinder: Cylinder | None

    @property
    def plant(self) -> MultibodyPlant:
        return self.built.plant

    @property
    def drakes(self) -> dict[str, float]:
        """Stiffness of the springs that are Drake's, by their joints' names."""
        springs = zip(self.names, self.stiffness.tolist(), self.native, strict=True)
        return {name: stiffness for name, stiffness, native in springs if native}

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


def machine(mechanics: Mechanics, drive: Drives) -> Machine:
    """Builds the plant with the drives' rotors and the dampers beside its springs."""
    moving = _Moving(mechanics, drive)
    built = arm_plant(
        mechanics.arm,
        moving.at_slot,
        point_inertia(mechanics.mass, mechanics.moment),
        mechanics.placed[0],
        mechanics.compensator,
    )
    cylinder = cylinder_of(built, mechanics.arm, mechanics.compensator)
    springs = (*moving.own, *moving.gives)
    own = np.full(mechanics.arm.n, -1)
    own[moving.sprung] = np.arange(len(moving.own))
    stiffness = [law.stiffest for law in mechanics.axial if law is not None]
    stiffness += [1 / give.compliance for give in moving.order]
    damping = [float(drive.damping[j]) for j in moving.sprung]
    damping += [GIVE_DAMPING / give.compliance for give in moving.order]
    return Machine(
        built,
        np.array([joint.position_start() for joint in moving.motors]),
        np.array([joint.position_start() for joint in springs], dtype=np.int64),
        tuple(joint.name() for joint in springs),
        own,
        np.array(stiffness),
        np.array(damping),
        np.array([*moving.of_joints, *(True for _ in moving.gives)], dtype=bool),
        cylinder,
    )


def mass_matrix(built: Machine, q: Array) -> Array:
    """(V, V) with the drives at joints q (n,) and the springs slack."""
    context = built.plant.CreateDefaultContext()
    place = np.zeros(built.plant.num_positions())
    place[built.motors] = q
    built.plant.SetPositions(context, place)
    return np.asarray(built.plant.CalcMassMatrix(context))


class _Moving:
    """What moves at the slots: hinges and slides, then drive and spring; and which joint is which."""

    def __init__(self, mechanics: Mechanics, drive: Drives) -> None:
        self.mechanics, self.drive = mechanics, drive
        self.motors: list[Joint] = []
        self.own: list[Joint] = []
        self.sprung: list[int] = []
        self.gives: list[Joint] = []
        self.order: list[Give] = []
        self.of_joints: list[bool] = []

    def at_slot(self, plant: MultibodyPlant, slot: int, frame: Frame) -> Frame:
        arm = self.mechanics.arm
        here = [give for give in self.mechanics.gives if give.slot == slot]
        for i, give in enumerate(here, start=1):
            joint = give_joint(
                plant,
                f"{arm.slot_names[slot]}_yield_{i}",
                frame,
                give.axis,
                give.point if give.turns else None,
                GIVE_DAMPING / give.compliance,
            )
            add_spring(plant, joint, 1 / give.compliance)
            self.gives.append(joint)
            self.order.append(give)
            frame = joint.child_body().body_frame()
        return self._drive(plant, slot, frame) if 1 <= slot <= arm.n else frame

    def _drive(self, plant: MultibodyPlant, slot: int, frame: Frame) -> Frame:
        arm, j = self.mechanics.arm, slot - 1
        name, ratio = arm.names[j], self.mechanics.robot.joints[j].data.gear_ratio or 1.0
        motor = axial_joint(plant, arm, slot, name, frame)
        add_rotor(plant, motor, float(self.drive.rotor[j]) / ratio**2, ratio)
        self.motors.append(motor)
        if (law := self.mechanics.axial[j]) is None:
            return motor.child_body().body_frame()
        behind, damping = motor.child_body().body_frame(), float(self.drive.damping[j])
        spring = axial_joint(plant, arm, slot, f"{name}_spring", behind, damping)
        if law.torque is None:
            add_spring(plant, spring, law.stiffest)
        self.of_joints.append(law.torque is None)
        self.own.append(spring)
        self.sprung.append(j)
        return spring.child_body().body_frame()
