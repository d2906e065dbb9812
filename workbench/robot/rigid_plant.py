"""The rigid twin, which is the user's URDF as Drake parses it, and the arrays that are taken from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    JointIndex,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    SpatialInertia,
)
from pydrake.systems.framework import Context

from .beam import bending_compliance
from .description import Robot
from .kinematics import RX, RY, RZ, TZ, Arm, Array
from .plants import urdf_plant
from .rotations import turn_z_to
from .schema import GEOMETRY


@dataclass(frozen=True)
class Twin:
    """A Drake plant of a robot with a Context of its own."""

    robot: Robot
    plant: MultibodyPlant
    context: Context

    def set_positions(self, q: Array) -> None:
        """Joint positions of the rigid twin, (n,) in the robot's order."""
        positions = self.plant.GetPositions(self.context)
        positions[[self.plant.GetJointByName(joint).position_start() for joint in self.robot.joint_names]] = q
        self.plant.SetPositions(self.context, positions)


def rigid_twin(robot: Robot) -> Twin:
    """The rigid twin, as its URDF has it (not corrected by `[geometry]`)."""
    plant = urdf_plant(robot)
    return Twin(robot, plant, plant.CreateDefaultContext())


def link_poses(robot: Robot, q: Array) -> Array:
    """(F, L, 4, 4) poses of base and links of the rigid twin at joints q (F, n)."""
    twin = rigid_twin(robot)
    links = [twin.plant.GetBodyByName(link) for link in (robot.base, *robot.links)]
    out = np.empty((len(q), len(links), 4, 4))
    for poses, joints in zip(out, q, strict=True):
        twin.set_positions(joints)
        for pose, link in zip(poses, links, strict=True):
            pose[:] = link.EvalPoseInWorld(twin.context).GetAsMatrix4()
    return out


def arrays(robot: Robot) -> Arm:
    """The arm's arrays, read from the rigid twin's Context."""
    twin = rigid_twin(robot)
    plant, context = twin.plant, twin.context
    n = len(robot.joints)
    slots = n + 2
    R, p = np.tile(np.eye(3), (slots, 1, 1)), np.zeros((slots, 3))
    R_link = np.tile(np.eye(3), (slots, 1, 1))
    chain = [plant.GetBodyByName(robot.base)]
    for i, joint in enumerate(robot.joints, start=1):
        moving = plant.GetJointByName(joint.name)
        R_JL = turn_z_to(_axis(moving))
        X_PJ = moving.frame_on_parent().CalcPose(context, chain[-1].body_frame())
        X_JC = moving.frame_on_child().GetFixedPoseInBodyFrame().inverse()
        R[i] = R_link[i - 1] @ X_PJ.rotation().matrix() @ R_JL
        p[i] = R_link[i - 1] @ X_PJ.translation()
        # link frames here are the joint's moving frame, turned; a child frame that is off the
        # joint is brought in by the link's own masses and points
        if not X_JC.IsNearlyEqualTo(RigidTransform(), 1e-12):
            raise ValueError(f"joint {joint.name}: child frame is not the link frame")
        R_link[i] = R_JL.T
        chain.append(moving.child_body())
    X_LF = plant.GetFrameByName(robot.flange).CalcPose(context, chain[-1].body_frame())
    R[-1], p[-1] = R_link[n] @ X_LF.rotation().matrix(), R_link[n] @ X_LF.translation()
    inertias = _inertias(plant, context, chain)
    mass = np.array([inertia.get_mass() for inertia in inertias])
    com = np.array([R @ inertia.get_com() for R, inertia in zip(R_link, inertias, strict=False)])
    rotary = np.array(
        [
            R @ inertia.CalcRotationalInertia().CopyToFullMatrix3() @ R.T
            for R, inertia in zip(R_link, inertias, strict=False)
        ]
    )
    prismatic = np.array(robot.sliding)
    return Arm(
        names=robot.joint_names,
        links=(robot.base, *robot.links),
        prismatic=prismatic,
        R=R,
        p=p,
        geometry=_geometry(robot),
        mass=mass,
        moment=mass[:, None] * com,
        inertia=rotary,
        R_link=R_link,
        gravity=np.array(robot.gravity),
        compliance=_compliance(robot, prismatic, np.einsum("sji,sj->si", R, p)),
    )


def _axis(joint: object) -> Array:
    if isinstance(joint, RevoluteJoint):
        return np.asarray(joint.revolute_axis())
    if isinstance(joint, PrismaticJoint):
        return np.asarray(joint.translation_axis())
    raise TypeError(f"{joint!r} is neither revolute nor prismatic")


def _inertias(plant: MultibodyPlant, context: Context, chain: list[RigidBody]) -> list[SpatialInertia]:
    """Spatial inertia of each link with all that hangs on it outside the chain, in its URDF frame."""
    inboard = {}
    for joint_index in range(plant.num_joints()):
        joint = plant.get_joint(JointIndex(joint_index))
        inboard[joint.child_body().name()] = joint.parent_body().name()
    names = [body.name() for body in chain]
    owned: list[list[BodyIndex]] = [[] for _ in chain]
    for index in plant.GetBodyIndices(chain[0].model_instance()):
        owner = plant.get_body(index).name()
        while owner not in names and owner in inboard:
            owner = inboard[owner]
        if owner in names:
            owned[names.index(owner)].append(index)
    return [
        plant.CalcSpatialInertia(context, body.body_frame(), indices)
        for body, indices in zip(chain, owned, strict=True)
    ]


def _geometry(robot: Robot) -> Array:
    geometry = np.zeros((len(robot.joints) + 2, 6))
    for i, name in enumerate(robot.corrected_frames, start=1):
        values = robot.geometry.get(name, {})
        geometry[i] = [values.get(key, 0.0) for key in GEOMETRY]
    return geometry


def _compliance(robot: Robot, prismatic: NDArray[np.bool_], span: Array) -> Array:
    """Compliance of each slot as the TOML states it: axial, tilt of the bearing, bending of the link
    that ends there."""
    compliance = np.zeros((len(robot.joints) + 2, 6, 6))
    for i, joint in enumerate(robot.joints, start=1):
        axial = TZ if prismatic[i - 1] else RZ
        if joint.data.stiffness is not None:
            compliance[i, axial, axial] = 1 / joint.data.stiffness
        if joint.data.tilt_stiffness is not None:
            compliance[i, RX, RX] = compliance[i, RY, RY] = 1 / joint.data.tilt_stiffness
    for i, link in enumerate((robot.base, *robot.links), start=1):
        if link in robot.bending_stiffness:
            compliance[i] += bending_compliance(span[i]) / robot.bending_stiffness[link]
    return compliance
