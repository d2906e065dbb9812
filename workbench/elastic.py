"""The elastic twin: the robot in Drake with everything that yields.

At every slot it has a FixedOffsetFrame for the geometric correction and small joints for what moves
there; at every joint also a motor joint, a motor body without mass but with rotor inertia, and a
spring joint. Everything that calibration changes (frame poses, masses, stiffness) lives in the Context.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    JacobianWrtVariable,
    PrismaticJoint,
    RevoluteJoint,
    RevoluteSpring,
    RigidBody,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.framework import Context

from .arm import RZ, TZ, Arm, Array
from .robot import GEOMETRY, Robot
from .statics import Law, Loads


@dataclass(frozen=True, eq=False)
class ElasticTwin:
    """The elastic twin. `yielding` maps (slot, component) to the joint that moves there.

    `motors`: names of the motor joints; `geometry_frames`: names of the frames that carry the geometric
    corrections; `links`: names of the bodies behind the slots. Masses, frame poses and stiffness are
    parameters of `context`. All joints have one degree of freedom.
    """

    arm: Arm
    plant: MultibodyPlant
    context: Context
    yielding: dict[tuple[int, int], str]
    motors: tuple[str, ...]
    geometry_frames: tuple[str, ...]
    links: tuple[str, ...]

    @cached_property
    def columns(self) -> NDArray[np.int64]:
        """Columns 6 · slot + component that have a joint."""
        return np.array([6 * slot + component for slot, component in self.yielding])

    @cached_property
    def _yielding_at(self) -> NDArray[np.int64]:
        """Place of the yielding joints in positions and velocities."""
        return self._at(tuple(self.yielding.values()))

    @cached_property
    def _motors_at(self) -> NDArray[np.int64]:
        return self._at(self.motors)

    def _at(self, joints: tuple[str, ...]) -> NDArray[np.int64]:
        return np.array([self.plant.GetJointByName(name).position_start() for name in joints])

    @cached_property
    def _bodies(self) -> list[RigidBody]:
        """The bodies behind the slots, and the payload."""
        return [self.plant.GetBodyByName(name) for name in (*self.links, "payload")]

    def set_geometry(self, geometry: Array) -> None:
        """Writes the corrections G: (S, 6) into the Context."""
        for i, name in enumerate(self.geometry_frames):
            X = slot_pose(self.arm, i + 1, geometry[i + 1])
            frame = self.plant.GetFrameByName(name)
            assert isinstance(frame, FixedOffsetFrame)
            frame.SetPoseInParentFrame(self.context, X)

    def set_masses(self, arm: Arm) -> None:
        """Writes the links' masses and centres of mass into the Context."""
        for slot in range(arm.n + 1):
            self._bodies[slot].SetSpatialInertiaInBodyFrame(self.context, link_inertia(arm, slot))

    def set_payload(self, mass: float, moment: Array) -> None:
        """Mass [kg] and mass times centre of mass (3,) [kg·m] of tool and payload, flange frame."""
        com = moment / mass if mass > 0 else np.zeros(3)
        point = np.eye(3) * (com @ com) - np.outer(com, com)
        inertia = _spatial_inertia(mass, com, point) if mass > 0 else SpatialInertia.Zero()
        self._bodies[-1].SetSpatialInertiaInBodyFrame(self.context, inertia)

    def equilibrium(self, q: Array, direct: Array, loads: Loads, law: Law) -> Array:
        """Drake's loaded equilibrium of one pose: slot motions (S, 6). The plant stays in it.

        q: (n,) commanded; direct: (S, 6) motions without load; `loads` of one pose (N = 1); `law`
        maps (1, S, 6) wrenches to motions. The torques are Drake's own.
        """
        self.set_payload(float(loads.mass[0]), loads.moment[0])
        self._refuse_without_joint(direct)
        motion = direct.copy()
        for _ in range(60):
            self._pose(q, motion)
            new = direct + law(self.wrenches(loads))[0]
            step = float(np.abs(new - motion).max())
            motion = new
            if step < 1e-14:
                self._refuse_without_joint(motion)
                self._pose(q, motion)
                return motion
        raise ArithmeticError("Drake's equilibrium was not reached")

    def wrenches(self, loads: Loads) -> Array:
        """Local wrenches (1, S, 6) at the present pose; zero where the twin has no joint."""
        torque = self.plant.CalcGravityGeneralizedForces(self.context) + self._applied(loads)
        local = np.zeros((1, 6 * self.arm.slots))
        local[0, self.columns] = torque[self._yielding_at]
        local[:, self.arm.axial] += loads.torque
        return local.reshape(1, self.arm.slots, 6)

    def _pose(self, q: Array, motion: Array) -> None:
        positions = np.empty(self.plant.num_positions())
        positions[self._motors_at] = q
        positions[self._yielding_at] = motion.reshape(-1)[self.columns]
        self.plant.SetPositions(self.context, positions)

    def _refuse_without_joint(self, motion: Array) -> None:
        rest = motion.reshape(-1).copy()
        rest[self.columns] = 0.0
        if rest.any():
            slot, component = divmod(int(np.flatnonzero(rest)[0]), 6)
            raise ValueError(f"the elastic twin was built without {GEOMETRY[component]} at slot {slot}")

    def _applied(self, loads: Loads) -> Array:
        """Generalised forces of the external wrench and of the compensator."""
        plant, context, world = self.plant, self.context, self.plant.world_frame()
        torque = np.zeros(plant.num_velocities())
        if loads.wrench.any():
            J = self._jacobian(self._bodies[-2].body_frame(), np.zeros(3))
            torque += J.T @ np.concatenate([loads.wrench[0, 3:], loads.wrench[0, :3]])
        if (law := loads.compensator) is not None:
            body, moving = self._bodies[law.body].body_frame(), self._bodies[law.arm].body_frame()
            b = plant.CalcPointsPositions(context, body, law.body_pivot, world)[:, 0]
            a = plant.CalcPointsPositions(context, moving, law.arm_pivot, world)[:, 0]
            s = float(np.linalg.norm(b - a))
            pull = float(law.force(np.array([s]))[0][0]) * (b - a) / s
            torque += self._jacobian(moving, law.arm_pivot)[3:].T @ pull
            torque -= self._jacobian(body, law.body_pivot)[3:].T @ pull
        return torque

    def _jacobian(self, frame: Frame, point: Array) -> Array:
        world = self.plant.world_frame()
        return np.asarray(
            self.plant.CalcJacobianSpatialVelocity(
                self.context, JacobianWrtVariable.kV, frame, point, world, world
            )
        )

    def points(self, targets: Array, on: Sequence[int]) -> Array:
        """Places of targets (T, 3) behind slots `on` at the present pose: (T, 3) [m]."""
        plant, context, world = self.plant, self.context, self.plant.world_frame()
        frames = [self._bodies[k].body_frame() for k in on]
        return np.array(
            [
                plant.CalcPointsPositions(context, frame, target, world)[:, 0]
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
    return _spatial_inertia(mass, arm.moment[slot] / mass, arm.inertia[slot] / mass)


def _spatial_inertia(mass: float, com: Array, unit: Array) -> SpatialInertia:
    """From mass, centre of mass and inertia per mass about the frame's origin (3, 3)."""
    return SpatialInertia(
        mass,
        com,
        UnitInertia(*np.diag(unit), unit[0, 1], unit[0, 2], unit[1, 2]),
        skip_validity_check=True,
    )
