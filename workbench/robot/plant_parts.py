"""The parts of the elastic twin in Drake: frames, small joints, motors, springs, bodies."""

from __future__ import annotations

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    PrismaticJoint,
    RevoluteJoint,
    RevoluteSpring,
    SpatialInertia,
    UnitInertia,
)

from .description import GEOMETRY, Robot
from .kinematics import RZ, TZ, Arm, Array


class Builder:
    """Adds bodies and joints slot by slot."""

    def __init__(self, plant: MultibodyPlant, arm: Arm, robot: Robot, wanted: set[tuple[int, int]]) -> None:
        self.plant, self.arm, self.robot, self.wanted = plant, arm, robot, wanted
        self.yielding: dict[tuple[int, int], str] = {}
        self.motors: list[str] = []
        self.geometry_frames: list[str] = []
        self.links: list[str] = []

    def build(self) -> None:
        parent: Frame = self.plant.world_frame()
        for slot in range(self.arm.slots):
            parent = self._slot(slot, parent)
        payload = self.plant.AddRigidBody("payload", SpatialInertia.Zero())
        self.plant.WeldFrames(parent, payload.body_frame())

    def _slot(self, slot: int, parent: Frame) -> Frame:
        """Frame of correction, small joints, motor and spring, body; returns the body's frame."""
        plant, arm = self.plant, self.arm
        joint = 1 <= slot <= arm.n
        name = arm.names[slot - 1] if joint else ("base" if slot == 0 else "flange")
        axial = None if not joint else TZ if arm.prismatic[slot - 1] else RZ
        corrected = FixedOffsetFrame(f"{name}_geometry", parent, slot_pose(arm, slot, arm.geometry[slot]))
        frame: Frame = plant.AddFrame(corrected)
        for component in range(6):
            if component != axial and (slot, component) in self.wanted:
                frame = self._free(slot, component, f"{name}_{GEOMETRY[component]}", frame)
        if axial is not None:
            self.geometry_frames.append(f"{name}_geometry")
            frame = self._motor(slot, axial, name, frame)
            frame = self._free(slot, axial, f"{name}_spring", frame)
            self._spring(slot, name)
        self.links.append(f"{name}_end")
        link = plant.AddRigidBody(f"{name}_end", link_inertia(arm, slot))
        plant.WeldFrames(frame, link.body_frame())
        return link.body_frame()

    def _free(self, slot: int, component: int, name: str, frame: Frame) -> Frame:
        """A joint that yields."""
        body = self.plant.AddRigidBody(f"{name}_body", SpatialInertia.Zero())
        self._joint(name, frame, body.body_frame(), component)
        self.yielding[(slot, component)] = name
        return body.body_frame()

    def _motor(self, slot: int, axial: int, name: str, frame: Frame) -> Frame:
        motor = self.plant.AddRigidBody(f"{name}_motor_body", SpatialInertia.Zero())
        self._joint(f"{name}_motor", frame, motor.body_frame(), axial)
        self.motors.append(f"{name}_motor")
        actuator = self.plant.AddJointActuator(f"{name}_actuator", self.plant.GetJointByName(f"{name}_motor"))
        data = self.robot.joints[slot - 1].data
        actuator.set_default_rotor_inertia(data.rotor_inertia)
        actuator.set_default_gear_ratio(data.gear_ratio or 1.0)
        return motor.body_frame()

    def _spring(self, slot: int, name: str) -> None:
        joint = self.plant.GetJointByName(f"{name}_spring")
        stiffness = self.robot.joints[slot - 1].data.stiffness
        if stiffness is not None and isinstance(joint, RevoluteJoint):
            self.plant.AddForceElement(RevoluteSpring(joint, 0.0, stiffness))

    def _joint(self, name: str, parent: Frame, child: Frame, component: int) -> None:
        axis = np.eye(3)[component % 3]
        kind = PrismaticJoint if component < 3 else RevoluteJoint
        self.plant.AddJoint(kind(name, parent, child, axis))


def link_inertia(arm: Arm, slot: int) -> SpatialInertia:
    """Of the link behind a slot, about its frame's origin (zero for the flange)."""
    mass = arm.mass[slot] if slot <= arm.n else 0.0
    if mass <= 0:
        return SpatialInertia.Zero()
    return spatial_inertia(mass, arm.moment[slot] / mass, arm.inertia[slot] / mass)


def spatial_inertia(mass: float, com: Array, unit: Array) -> SpatialInertia:
    """From mass, centre of mass and inertia per mass about the frame's origin (3, 3)."""
    return SpatialInertia(
        mass,
        com,
        UnitInertia(*np.diag(unit), unit[0, 1], unit[0, 2], unit[1, 2]),
        skip_validity_check=True,
    )


def slot_pose(arm: Arm, slot: int, correction: Array) -> RigidTransform:
    """Pose of a slot in its parent link with correction G = Trans Rx Ry Rz."""
    R = RotationMatrix.MakeXRotation(correction[3]) @ RotationMatrix.MakeYRotation(correction[4])
    G = RigidTransform(R @ RotationMatrix.MakeZRotation(correction[5]), correction[:3])
    return RigidTransform(RotationMatrix(arm.R[slot]), arm.p[slot]) @ G
