"""The parts that Drake plants are made of: poses of slots, inertias, joints that yield, drives, springs.

A joint comes with a body without mass behind it; the next part sits on that body's frame.
"""

from __future__ import annotations

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    Joint,
    LinearSpringDamper,
    PrismaticJoint,
    PrismaticSpring,
    RevoluteJoint,
    RevoluteSpring,
    RigidBody,
    SpatialInertia,
    UnitInertia,
)

from .compensator import CompensatorLaw
from .kinematics import RX, RY, RZ, Arm, Array


def motion_transform(motion: Array) -> RigidTransform:
    """Trans(tx, ty, tz) Rx Ry Rz of one slot's motion or correction (6,)."""
    R = RotationMatrix.MakeXRotation(motion[RX]) @ RotationMatrix.MakeYRotation(motion[RY])
    return RigidTransform(R @ RotationMatrix.MakeZRotation(motion[RZ]), motion[:RX])


def slot_pose(arm: Arm, slot: int, correction: Array) -> RigidTransform:
    """Pose of a slot in its parent link with the correction G (6,)."""
    return RigidTransform(RotationMatrix(arm.R[slot]), arm.p[slot]) @ motion_transform(correction)


def link_inertia(arm: Arm, slot: int) -> SpatialInertia:
    """Of the link behind a slot, about the origin of its URDF frame and on its axes."""
    mass, R = arm.mass[slot], arm.R_link[slot].T
    if mass <= 0:
        return SpatialInertia.Zero()
    return spatial_inertia(mass, R @ arm.moment[slot] / mass, R @ arm.inertia[slot] @ R.T / mass)


def point_inertia(mass: float, moment: Array) -> SpatialInertia:
    """Of tool and payload as one point: mass [kg], mass times its place (3,) [kg·m]."""
    if mass <= 0:
        return SpatialInertia.Zero()
    com = moment / mass
    return spatial_inertia(mass, com, np.eye(3) * (com @ com) - np.outer(com, com))


def spatial_inertia(mass: float, com: Array, unit: Array) -> SpatialInertia:
    """From mass, centre of mass and inertia per mass about the frame's origin (3, 3)."""
    return SpatialInertia(
        mass,
        com,
        UnitInertia(*np.diag(unit), unit[0, 1], unit[0, 2], unit[1, 2]),
        skip_validity_check=True,
    )


def component_joint(
    plant: MultibodyPlant, name: str, frame: Frame, component: int, damping: float = 0.0
) -> Joint:
    """A joint along one component of a slot's motion. damping: [N·m·s/rad, N·s/m]."""
    kind = PrismaticJoint if component < RX else RevoluteJoint
    body = plant.AddRigidBody(f"{name}_body", SpatialInertia.Zero())
    return plant.AddJoint(kind(name, frame, body.body_frame(), np.eye(3)[component % 3], damping=damping))


def axial_joint(
    plant: MultibodyPlant, arm: Arm, slot: int, name: str, frame: Frame, damping: float = 0.0
) -> Joint:
    """A joint along the slot's own axis: of the robot's joint, its motor, or its spring."""
    return component_joint(plant, name, frame, int(arm.axial[slot - 1]) % 6, damping)


def give_joint(
    plant: MultibodyPlant, name: str, frame: Frame, axis: Array, point: Array | None, damping: float
) -> Joint:
    """A joint that turns about `axis` (3,) through `point` (3,) [m], or shifts along it (None)."""
    body = plant.AddRigidBody(f"{name}_body", SpatialInertia.Zero())
    X = RigidTransform(np.zeros(3) if point is None else point)
    on_parent = plant.AddFrame(FixedOffsetFrame(f"{name}_parent", frame, X))
    on_child = plant.AddFrame(FixedOffsetFrame(f"{name}_child", body.body_frame(), X))
    kind = PrismaticJoint if point is None else RevoluteJoint
    return plant.AddJoint(kind(name, on_parent, on_child, axis, damping=damping))


def add_rotor(plant: MultibodyPlant, joint: Joint, inertia: float, gear_ratio: float) -> None:
    """Gives a joint's own motion the inertia of a rotor [kg·m² on the rotor's side]."""
    actuator = plant.AddJointActuator(f"{joint.name()}_rotor", joint)
    actuator.set_default_rotor_inertia(inertia)
    actuator.set_default_gear_ratio(gear_ratio)


def add_spring(plant: MultibodyPlant, joint: Joint, stiffness: float) -> RevoluteSpring | PrismaticSpring:
    """A spring across a joint, slack at zero [N·m/rad, N/m]."""
    kind = RevoluteSpring if isinstance(joint, RevoluteJoint) else PrismaticSpring
    spring: RevoluteSpring | PrismaticSpring = plant.AddForceElement(kind(joint, 0.0, stiffness))  # type: ignore[assignment]
    return spring


def pivots(arm: Arm, law: CompensatorLaw) -> tuple[Array, Array]:
    """The compensator's pivots (3,) [m] on its two links, each in the body frame of its own."""
    return arm.R_link[law.body].T @ law.body_pivot, arm.R_link[law.arm].T @ law.arm_pivot


def add_coil(
    plant: MultibodyPlant, bodies: tuple[RigidBody, ...], arm: Arm, law: CompensatorLaw
) -> LinearSpringDamper:
    """A compensator's coil spring between its pivots. Raises ValueError for one that is no coil."""
    if law.coil is None:
        raise ValueError("a gas cylinder is no coil spring")
    rate, free = law.coil
    on_body, on_arm = pivots(arm, law)
    coil = LinearSpringDamper(bodies[law.body], on_body, bodies[law.arm], on_arm, free, rate, 0.0)
    plant.AddForceElement(coil)
    return coil
