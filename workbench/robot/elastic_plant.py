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
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    JacobianWrtVariable,
    RigidBody,
    SpatialInertia,
)
from pydrake.systems.framework import Context

from .description import GEOMETRY, Robot
from .kinematics import Arm, Array
from .plant_parts import Builder, link_inertia, slot_pose, spatial_inertia
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
        inertia = spatial_inertia(mass, com, point) if mass > 0 else SpatialInertia.Zero()
        self._bodies[-1].SetSpatialInertiaInBodyFrame(self.context, inertia)

    def equilibrium(self, q: Array, direct: Array, loads: Loads, law: Law) -> Array:
        """Drake's loaded equilibrium of one pose: slot motions (S, 6). The plant stays in it.

        q: (n,) commanded; direct: (S, 6) motions without load; `loads` of one pose (N = 1); `law`
        maps (1, S, 6) wrenches to motions. The torques are Drake's own.
        """
        self.set_payload(float(loads.mass[0]), loads.moment[0])
        self._refuse_without_joint(direct)
        motion, last = direct.copy(), np.inf
        for _ in range(60):
            self._pose(q, motion)
            new = direct + law(self.wrenches(loads))[0]
            step = float(np.abs(new - motion).max())
            motion = new
            if step < 1e-14 or (step < 1e-10 and step > 0.5 * last):  # as still as rounding allows
                self._refuse_without_joint(motion)
                self._pose(q, motion)
                return motion
            last = step
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
    builder = Builder(plant, arm, robot, set(yielding))
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
