"""The robot in Drake: the rigid twin, the elastic twin, and the arrays that `arm.py` works on.

The rigid twin is the user's URDF as Drake parses it. The elastic twin has, at every joint, a
FixedOffsetFrame for the geometric correction, small joints for what else yields there, a motor
joint, a motor body without mass but with rotor inertia, and a spring joint. Everything that
calibration changes (frame poses, masses, stiffness) lives in the Context.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    FixedOffsetFrame,
    JacobianWrtVariable,
    JointIndex,
    PrismaticJoint,
    RevoluteJoint,
    RevoluteSpring,
    RigidBody,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.framework import Context

from .arm import RX, RY, RZ, TZ, Arm, Array
from .beam import bending_compliance
from .robot import GEOMETRY, Robot
from .statics import CompensatorLaw, Law, Loads

SLIDE, TURN = range(3), range(3, 6)


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
    """The robot's URDF in Drake, base welded to the world, gravity as the TOML says."""
    plant = MultibodyPlant(0.0)
    parse_urdf(plant, robot.urdf)
    plant.mutable_gravity_field().set_gravity_vector(np.array(robot.gravity))
    base = plant.GetBodyByName(robot.base)
    plant.WeldFrames(plant.world_frame(), base.body_frame())
    plant.Finalize()
    return Twin(robot, plant, plant.CreateDefaultContext())


def parse_urdf(plant: MultibodyPlant, urdf: Path) -> None:
    """Adds the URDF's model to a plant."""
    Parser(plant).AddModels(str(urdf))


def arrays(robot: Robot, twin: Twin | None = None) -> Arm:
    """The arm's arrays, read from the rigid twin's Context (once)."""
    twin = twin or rigid_twin(robot)
    plant, context = twin.plant, twin.context
    n = len(robot.joints)
    slots = n + 2
    R, p = np.tile(np.eye(3), (slots, 1, 1)), np.zeros((slots, 3))
    R_link = np.tile(np.eye(3), (slots, 1, 1))
    chain = [plant.GetBodyByName(robot.base)]
    for i, joint in enumerate(robot.joints, start=1):
        moving = plant.GetJointByName(joint.name)
        R_JL = _turn_z_to(_axis(moving))
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
    prismatic = np.array([joint.kind == "prismatic" for joint in robot.joints])
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


def _turn_z_to(axis: Array) -> Array:
    """Smallest rotation that takes z to `axis` (a half turn about x for −z)."""
    if axis[2] < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    v = np.cross([0.0, 0.0, 1.0], axis)
    V = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + V + V @ V / (1 + axis[2])


def _inertias(plant: MultibodyPlant, context: Context, chain: list[RigidBody]) -> list[SpatialInertia]:
    """Spatial inertia of each link with all that hangs on it outside the chain, in its URDF frame."""
    inboard = {}
    for index in range(plant.num_joints()):
        joint = plant.get_joint(JointIndex(index))
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
    for i, name in enumerate(robot.joint_names, start=1):
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


def compensator_law(robot: Robot, arm: Arm) -> CompensatorLaw | None:
    """The TOML's compensator in the arm's frames."""
    data = robot.compensator
    if data is None:
        return None
    body, moving = arm.slot_of_link(data.body), arm.slot_of_link(data.arm)
    return CompensatorLaw(
        data,
        body,
        moving,
        arm.R_link[body] @ np.array(data.body_pivot),
        arm.R_link[moving] @ np.array(data.arm_pivot),
    )


# ---------------------------------------------------------------- the elastic twin


@dataclass(frozen=True)
class ElasticTwin:
    """The elastic twin. `yielding` maps (slot, component) to the joint that moves there.

    `motors`: names of the motor joints; `frames`: names of the frames that carry the geometric
    corrections; masses, frame poses and stiffness are parameters of `context`.
    """

    arm: Arm
    plant: MultibodyPlant
    context: Context
    yielding: dict[tuple[int, int], str]
    motors: tuple[str, ...]
    geometry_frames: tuple[str, ...]
    links: tuple[str, ...]

    def _index(self, joint: str) -> int:
        """Place of a one-degree joint in positions and velocities (all joints here have one)."""
        return int(self.plant.GetJointByName(joint).position_start())

    def set_geometry(self, geometry: Array) -> None:
        """Writes the corrections G: (S, 6) into the Context."""
        for i, name in enumerate(self.geometry_frames):
            X = slot_pose(self.arm, i + 1, geometry[i + 1])
            self.plant.GetFrameByName(name).SetPoseInParentFrame(self.context, X)

    def set_payload(self, mass: float, moment: Array) -> None:
        """Mass [kg] and mass times centre of mass (3,) [kg·m] of tool and payload, flange frame."""
        com = moment / mass if mass > 0 else np.zeros(3)
        point = np.eye(3) * (com @ com) - np.outer(com, com)
        inertia = _spatial_inertia(mass, com, point) if mass > 0 else SpatialInertia.Zero()
        self.plant.GetBodyByName("payload").SetSpatialInertiaInBodyFrame(self.context, inertia)

    def equilibrium(self, q: Array, direct: Array, loads: Loads, law: Law) -> Array:
        """Drake's loaded equilibrium of one pose: slot motions (S, 6).

        q: (n,) commanded; direct: (S, 6) motions without load; `loads` of one pose (N = 1); `law`
        maps (1, S, 6) wrenches to motions. The torques are Drake's own.
        """
        plant, context = self.plant, self.context
        self.set_payload(float(loads.mass[0]), loads.moment[0])
        motion = direct.copy()
        for _ in range(60):
            self._pose(q, motion)
            torque = plant.CalcGravityGeneralizedForces(context) + self._applied(loads)
            local = np.zeros((1, self.arm.slots, 6))
            for (slot, component), name in self.yielding.items():
                local[0, slot, component] = torque[self._index(name)]
            local.reshape(1, -1)[:, self.arm.axial] += loads.torque
            new = direct + law(local)[0]
            step = float(np.abs(new - motion).max())
            motion = new
            if step < 1e-14:
                self._pose(q, motion)
                return motion
        raise ArithmeticError("Drake's equilibrium was not reached")

    def _pose(self, q: Array, motion: Array) -> None:
        positions = np.zeros(self.plant.num_positions())
        positions[[self._index(name) for name in self.motors]] = q
        for (slot, component), name in self.yielding.items():
            positions[self._index(name)] = motion[slot, component]
        self.plant.SetPositions(self.context, positions)

    def _applied(self, loads: Loads) -> Array:
        plant, context = self.plant, self.context
        flange = plant.GetFrameByName("flange_end")
        J = self._jacobian(flange, np.zeros(3))
        torque = J.T @ np.concatenate([loads.wrench[0, 3:], loads.wrench[0, :3]])
        law = loads.compensator
        if law is not None:
            body = plant.GetFrameByName(self.links[law.body])
            moving = plant.GetFrameByName(self.links[law.arm])
            b = plant.CalcPointsPositions(context, body, law.body_pivot, plant.world_frame())[:, 0]
            a = plant.CalcPointsPositions(context, moving, law.arm_pivot, plant.world_frame())[:, 0]
            s = float(np.linalg.norm(b - a))
            pull = float(law.force(np.array([s]))[0][0]) * (b - a) / s
            torque = torque + self._jacobian(moving, law.arm_pivot)[3:].T @ pull
            torque = torque - self._jacobian(body, law.body_pivot)[3:].T @ pull
        return np.asarray(torque)

    def _jacobian(self, frame: object, point: Array) -> Array:
        world = self.plant.world_frame()
        return np.asarray(
            self.plant.CalcJacobianSpatialVelocity(
                self.context, JacobianWrtVariable.kV, frame, point, world, world
            )
        )

    def points(self, targets: Array, on: Sequence[int]) -> Array:
        """Places of targets (T, 3) behind slots `on` at the present pose: (T, 3) [m]."""
        world = self.plant.world_frame()
        frames = [self.plant.GetFrameByName(self.links[k]) for k in on]
        return np.array(
            [
                self.plant.CalcPointsPositions(self.context, frame, target, world)[:, 0]
                for frame, target in zip(frames, targets, strict=True)
            ]
        )


def slot_pose(arm: Arm, slot: int, correction: Array) -> RigidTransform:
    """Pose of a slot in its parent link with correction G = Trans Rx Ry Rz."""
    R = RotationMatrix.MakeXRotation(correction[3]) @ RotationMatrix.MakeYRotation(correction[4])
    G = RigidTransform(R @ RotationMatrix.MakeZRotation(correction[5]), correction[:3])
    return RigidTransform(RotationMatrix(arm.R[slot]), arm.p[slot]) @ G


def elastic_twin(arm: Arm, robot: Robot, yielding: Sequence[tuple[int, int]] | None = None) -> ElasticTwin:
    """Builds the elastic twin of an arm.

    `yielding`: the (slot, component) pairs that get a joint of their own; default: all six of every
    slot, so that any effect can be set in the Context without a rebuild. The axial spring joints
    are always there.
    """
    if yielding is None:
        yielding = [(slot, c) for slot in range(arm.slots) for c in range(6)]
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(arm.gravity)
    builder = _Builder(plant, arm, robot, set(yielding))
    builder.build()
    plant.Finalize()
    return ElasticTwin(
        arm,
        plant,
        plant.CreateDefaultContext(),
        builder.yielding,
        tuple(builder.motors),
        tuple(builder.geometry_frames),
        tuple(builder.links),
    )


class _Builder:
    """Adds bodies and joints slot by slot."""

    def __init__(self, plant: MultibodyPlant, arm: Arm, robot: Robot, wanted: set[tuple[int, int]]) -> None:
        self.plant, self.arm, self.robot, self.wanted = plant, arm, robot, wanted
        self.yielding: dict[tuple[int, int], str] = {}
        self.motors: list[str] = []
        self.geometry_frames: list[str] = []
        self.links: list[str] = []

    def build(self) -> None:
        parent = self.plant.world_frame()
        for slot in range(self.arm.slots):
            parent = self._slot(slot, parent)

    def _slot(self, slot: int, parent: object) -> object:
        plant, arm = self.plant, self.arm
        name = f"{arm.names[slot - 1]}" if 1 <= slot <= arm.n else ("base" if slot == 0 else "flange")
        frame = plant.AddFrame(
            FixedOffsetFrame(f"{name}_geometry", parent, slot_pose(arm, slot, arm.geometry[slot]))
        )
        if 1 <= slot <= arm.n:
            self.geometry_frames.append(f"{name}_geometry")
        joint = 1 <= slot <= arm.n
        sliding = joint and bool(arm.prismatic[slot - 1])
        order = (0, 1, 3, 4, 5) if sliding else (0, 1, 2, 3, 4) if joint else (0, 1, 2, 3, 4, 5)
        body = None
        for component in order:
            if (slot, component) in self.wanted:
                frame, body = self._free(
                    slot, component, f"{name}_{'tx ty tz rx ry rz'.split()[component]}", frame
                )
        if joint:
            axial = TZ if sliding else RZ
            motor = plant.AddRigidBody(f"{name}_motor_body", SpatialInertia.Zero())
            self._joint(f"{name}_motor", frame, motor.body_frame(), axial)
            self.motors.append(f"{name}_motor")
            actuator = plant.AddJointActuator(f"{name}_actuator", plant.GetJointByName(f"{name}_motor"))
            data = self.robot.joints[slot - 1].data
            actuator.set_default_rotor_inertia(data.rotor_inertia)
            actuator.set_default_gear_ratio(data.gear_ratio or 1.0)
            frame, body = self._free(slot, axial, f"{name}_spring", motor.body_frame())
            if data.stiffness is not None and not sliding:
                plant.AddForceElement(
                    RevoluteSpring(plant.GetJointByName(f"{name}_spring"), 0.0, data.stiffness)
                )
        end = f"{name}_end"
        inertia = self._inertia(slot)
        link = plant.AddRigidBody(end, inertia)
        plant.WeldFrames(frame, link.body_frame())
        self.links.append(end)
        if slot == arm.slots - 1:
            payload = plant.AddRigidBody("payload", SpatialInertia.Zero())
            plant.WeldFrames(link.body_frame(), payload.body_frame())
        del body
        return link.body_frame()

    def _free(self, slot: int, component: int, name: str, frame: object) -> tuple[object, RigidBody]:
        body = self.plant.AddRigidBody(f"{name}_body", SpatialInertia.Zero())
        self._joint(name, frame, body.body_frame(), component)
        self.yielding[(slot, component)] = name
        return body.body_frame(), body

    def _joint(self, name: str, parent: object, child: object, component: int) -> None:
        axis = np.eye(3)[component % 3]
        kind = PrismaticJoint if component in SLIDE else RevoluteJoint
        self.plant.AddJoint(kind(name, parent, child, axis))

    def _inertia(self, slot: int) -> SpatialInertia:
        mass = self.arm.mass[slot] if slot <= self.arm.n else 0.0
        if mass <= 0:
            return SpatialInertia.Zero()
        return _spatial_inertia(mass, self.arm.moment[slot] / mass, self.arm.inertia[slot] / mass)


def _spatial_inertia(mass: float, com: Array, unit: Array) -> SpatialInertia:
    """From mass, centre of mass and inertia per mass about the frame's origin (3, 3)."""
    return SpatialInertia(
        mass,
        com,
        UnitInertia(*np.diag(unit), unit[0, 1], unit[0, 2], unit[1, 2]),
        skip_validity_check=True,
    )
