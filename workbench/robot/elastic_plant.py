"""The elastic twin: the robot in Drake with everything that yields.

At every slot it has a frame for the geometric correction and small joints for what moves there; at every
joint also a motor joint with the rotor's inertia, and a spring joint with its spring. Everything that
calibration changes (frame poses, masses, stiffness) lives in the Context.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JacobianWrtVariable
from pydrake.systems.framework import Context

from .description import Robot
from .equilibrium import Law, NoRest
from .kinematics import Arm, Array
from .loads import Loads
from .plant_parts import (
    add_rotor,
    add_spring,
    axial_joint,
    component_joint,
    link_inertia,
    point_inertia,
    slot_pose,
)
from .plants import ArmPlant, arm_plant
from .schema import GEOMETRY


@dataclass(frozen=True, eq=False)
class ElasticTwin:
    """The elastic twin. `yielding` maps (slot, component) to the joint that moves there; `motors`: names of
    the motor joints, base to flange.

    Masses, frame poses and stiffness are parameters of `context`. All joints have one degree of freedom.
    """

    arm: Arm
    built: ArmPlant
    context: Context
    yielding: dict[tuple[int, int], str]
    motors: tuple[str, ...]

    @property
    def plant(self) -> MultibodyPlant:
        return self.built.plant

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

    def set_geometry(self, geometry: Array) -> None:
        """Writes the corrections G of the joints: (S, 6) into the Context."""
        for slot in range(1, self.arm.n + 1):
            X = slot_pose(self.arm, slot, geometry[slot])
            self.built.corrected[slot].SetPoseInParentFrame(self.context, X)

    def set_masses(self, arm: Arm) -> None:
        """Writes the masses and centres of mass of base and links into the Context."""
        for slot in range(arm.n + 1):
            inertia = link_inertia(arm, slot)
            self.built.bodies[slot].SetSpatialInertiaInBodyFrame(self.context, inertia)

    def set_payload(self, mass: float, moment: Array) -> None:
        """Mass [kg] and mass times centre of mass (3,) [kg·m] of tool and payload, flange frame."""
        self.built.bodies[-1].SetSpatialInertiaInBodyFrame(self.context, point_inertia(mass, moment))

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
        raise NoRest

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
            J = self._jacobian(self.built.slots[-1], np.zeros(3))
            torque += J.T @ np.concatenate([loads.wrench[0, 3:], loads.wrench[0, :3]])
        if (law := loads.compensator) is not None:
            body, moving = self.built.slots[law.body], self.built.slots[law.arm]
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
        frames = [self.built.slots[k] for k in on]
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
    wanted, motors = set(yielding), []
    joints: dict[tuple[int, int], str] = {}

    def moving(plant: MultibodyPlant, slot: int, frame: Frame) -> Frame:
        """Small joints, then motor and spring."""
        name = arm.slot_names[slot]
        axial = int(arm.axial[slot - 1]) % 6 if 1 <= slot <= arm.n else None
        for component, key in enumerate(GEOMETRY):
            if component != axial and (slot, component) in wanted:
                free = component_joint(plant, f"{name}_{key}", frame, component)
                joints[slot, component] = free.name()
                frame = free.child_body().body_frame()
        if axial is None:
            return frame
        data = robot.joint(name).data
        motor = axial_joint(plant, arm, slot, f"{name}_motor", frame)
        add_rotor(plant, motor, data.rotor_inertia, data.gear_ratio or 1.0)
        motors.append(motor.name())
        spring = axial_joint(plant, arm, slot, f"{name}_spring", motor.child_body().body_frame())
        if data.stiffness is not None:
            add_spring(plant, spring, data.stiffness)
        joints[slot, axial] = spring.name()
        return spring.child_body().body_frame()

    twin = arm_plant(arm, moving)
    return ElasticTwin(arm, twin, twin.plant.CreateDefaultContext(), joints, tuple(motors))
