"""The true robot as a continuous Drake plant: drives, springs, links, payload.

Explicit integration at 1 ms bears no mode above `FASTEST`. So each spring joint gets the rotor inertia
K/ω² of its own (it slows the joint's own yielding, and nothing else): whatever hangs on it, no mode is
faster then, and real modes of 10 to 50 Hz stay where they are within a few per cent. Statics don't change.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    Joint,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    ScrewJoint,
    SpatialInertia,
)

from ...robot.kinematics import Arm, Array
from ...robot.plant_parts import link_inertia, slot_pose, spatial_inertia
from .mechanics import Mechanics, Screw

FASTEST = 800.0  # rad/s
POINT = np.eye(3)


@dataclass(frozen=True, eq=False)
class Machine:
    """The plant and where things are in it. n joints, K springs: first the joints' own, then the screws.

    motors: (n,), springs: (K,) places in positions and velocities; own: (n,) place among the springs of
    each joint's own spring, −1 for none. stiffness: (K,) [N·m/rad, N/m]. flange: frame with the tool.
    links: bodies behind the slots. rotor: (n,) reflected inertia of the drives [kg·m², kg].
    """

    plant: MultibodyPlant
    motors: NDArray[np.int64]
    springs: NDArray[np.int64]
    own: NDArray[np.int64]
    stiffness: Array
    flange: Frame
    links: tuple[RigidBody, ...]
    rotor: Array


def machine(mechanics: Mechanics, rotor: Array) -> Machine:
    """Builds the plant. rotor: (n,) reflected inertia of each drive [kg·m², kg]."""
    build = _Build(mechanics, rotor)
    parent: Frame = build.plant.world_frame()
    for slot in range(mechanics.arm.slots):
        parent = build.slot(slot, parent)
    plant = build.plant
    payload = plant.AddRigidBody("payload", payload_inertia(mechanics.mass, mechanics.moment))
    plant.WeldFrames(parent, payload.body_frame())
    plant.Finalize()
    springs = [joint.position_start() for joint in (*build.own, *build.screws)]
    own = np.full(mechanics.arm.n, -1)
    own[build.sprung] = np.arange(len(build.own))
    stiffness = [law.stiffest for law in mechanics.axial if law is not None]
    stiffness += [1 / screw.compliance for screw in build.order]
    return Machine(
        plant,
        np.array([joint.position_start() for joint in build.motors]),
        np.array(springs, dtype=np.int64),
        own,
        np.array(stiffness),
        parent,
        tuple(build.links),
        np.asarray(rotor, float),
    )


def slowest_mode(built: Machine, q: Array) -> float:
    """[rad/s] of the arm on its springs, drives locked at joints q (n,); infinite for a rigid arm."""
    if not len(built.springs):
        return float("inf")
    context = built.plant.CreateDefaultContext()
    place = np.zeros(built.plant.num_positions())
    place[built.motors] = q
    built.plant.SetPositions(context, place)
    M = built.plant.CalcMassMatrix(context)[np.ix_(built.springs, built.springs)]
    scale = 1 / np.sqrt(built.stiffness)
    return float(1 / np.sqrt(np.linalg.eigvalsh(scale[:, None] * M * scale).max()))


def rigid_machine(arm: Arm, mass: float, moment: Array) -> tuple[MultibodyPlant, NDArray[np.int64]]:
    """The arm without springs, drives and gravity, and its joints' places: for feed-forward."""
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    parent: Frame = plant.world_frame()
    joints = []
    for slot in range(arm.slots):
        X = slot_pose(arm, slot, arm.geometry[slot])
        frame: Frame = plant.AddFrame(FixedOffsetFrame(f"slot_{slot}", parent, X))
        body = plant.AddRigidBody(f"link_{slot}", link_inertia(arm, slot))
        if 1 <= slot <= arm.n:
            kind = PrismaticJoint if arm.prismatic[slot - 1] else RevoluteJoint
            joints.append(
                plant.AddJoint(kind(arm.names[slot - 1], frame, body.body_frame(), np.array([0, 0, 1.0])))
            )
        else:
            plant.WeldFrames(frame, body.body_frame())
        parent = body.body_frame()
    payload = plant.AddRigidBody("payload", payload_inertia(mass, moment))
    plant.WeldFrames(parent, payload.body_frame())
    plant.Finalize()
    return plant, np.array([joint.position_start() for joint in joints])


def payload_inertia(mass: float, moment: Array) -> SpatialInertia:
    """Tool and payload as a point."""
    if mass <= 0:
        return SpatialInertia.Zero()
    com = moment / mass
    return spatial_inertia(mass, com, POINT * (com @ com) - np.outer(com, com))


class _Build:
    """Adds slot by slot: frame with its corrections, screws, drive, spring, link."""

    def __init__(self, mechanics: Mechanics, rotor: Array) -> None:
        self.mechanics, self.rotor = mechanics, rotor
        self.plant = MultibodyPlant(0.0)
        self.plant.mutable_gravity_field().set_gravity_vector(mechanics.arm.gravity)
        self.motors: list[Joint] = []
        self.own: list[Joint] = []
        self.sprung: list[int] = []
        self.screws: list[Joint] = []
        self.order: list[Screw] = []
        self.links: list[RigidBody] = []

    def slot(self, slot: int, parent: Frame) -> Frame:
        arm = self.mechanics.arm
        X = slot_pose(arm, slot, arm.geometry[slot]) @ _moved(self.mechanics.placed[slot])
        frame: Frame = self.plant.AddFrame(FixedOffsetFrame(f"slot_{slot}", parent, X))
        for screw in self.mechanics.screws:
            if screw.slot == slot:
                frame = self._screw(screw, frame)
        if 1 <= slot <= arm.n:
            frame = self._drive(slot - 1, frame)
        link = self.plant.AddRigidBody(f"link_{slot}", link_inertia(arm, slot))
        self.plant.WeldFrames(frame, link.body_frame())
        self.links.append(link)
        return link.body_frame()

    def _screw(self, screw: Screw, frame: Frame) -> Frame:
        name = f"screw_{len(self.screws)}"
        body = self.plant.AddRigidBody(f"{name}_body", SpatialInertia.Zero())
        X = RigidTransform(screw.point)
        on_parent = self.plant.AddFrame(FixedOffsetFrame(f"{name}_parent", frame, X))
        on_child = self.plant.AddFrame(FixedOffsetFrame(f"{name}_child", body.body_frame(), X))
        joint: Joint
        if screw.shift:
            joint = PrismaticJoint(name, on_parent, on_child, screw.axis)
        elif screw.pitch:
            joint = ScrewJoint(name, on_parent, on_child, screw.axis, 2 * np.pi * screw.pitch, 0.0)
        else:
            joint = RevoluteJoint(name, on_parent, on_child, screw.axis)
        self.screws.append(self._joint(joint, 1 / screw.compliance / FASTEST**2))
        self.order.append(screw)
        return body.body_frame()

    def _drive(self, j: int, frame: Frame) -> Frame:
        arm, law = self.mechanics.arm, self.mechanics.axial[j]
        kind = PrismaticJoint if arm.prismatic[j] else RevoluteJoint
        z = np.array([0.0, 0.0, 1.0])
        body = self.plant.AddRigidBody(f"motor_{j}_body", SpatialInertia.Zero())
        motor = kind(f"motor_{j}", frame, body.body_frame(), z)
        self.motors.append(self._joint(motor, float(self.rotor[j])))
        if law is None:
            return body.body_frame()
        end = self.plant.AddRigidBody(f"spring_{j}_body", SpatialInertia.Zero())
        spring = kind(f"spring_{j}", body.body_frame(), end.body_frame(), z)
        self.own.append(self._joint(spring, law.stiffest / FASTEST**2))
        self.sprung.append(j)
        return end.body_frame()

    def _joint(self, joint: Joint, inertia: float) -> Joint:
        """Adds a joint whose own motion has this inertia."""
        added = self.plant.AddJoint(joint)
        actuator = self.plant.AddJointActuator(f"{joint.name()}_rotor", added)
        actuator.set_default_rotor_inertia(inertia)
        actuator.set_default_gear_ratio(1.0)
        return added


def _moved(motion: Array) -> RigidTransform:
    """T = Trans Rx Ry Rz of a slot."""
    R = RotationMatrix.MakeXRotation(motion[3]) @ RotationMatrix.MakeYRotation(motion[4])
    return RigidTransform(R @ RotationMatrix.MakeZRotation(motion[5]), motion[:3])
