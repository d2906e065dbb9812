"""The compensator as bodies: a cylinder on one pivot, its rod on the other, each pointing at the other pivot.

Both have no mass and feel nothing: what pulls are the plant's own elements. They are there to be looked at.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.geometry import Cylinder, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BallRpyJoint, FixedOffsetFrame, RigidBody, SpatialInertia
from pydrake.systems.framework import Context

from .compensator import CompensatorLaw
from .description import Robot
from .kinematics import Arm, Array, frames
from .plant_parts import pivots
from .rotations import turn_z_to

NAMES = ("compensator_cylinder", "compensator_rod")
COLOURS = {"gas": ([0.3, 0.32, 0.35, 1.0], [0.78, 0.8, 0.82, 1.0]),
           "spring": ([0.75, 0.1, 0.1, 1.0], [0.78, 0.8, 0.82, 1.0])}  # fmt: skip
WIDTH = {"gas": 0.055, "spring": 0.07}  # m, the cylinder's radius; the rod has 0.4 of it


@dataclass(frozen=True, eq=False)
class DrawnCylinder:
    """The two bodies' joints, and the bodies that carry them; `pivots` (3,) [m] in these."""

    joints: tuple[BallRpyJoint, BallRpyJoint]
    carriers: tuple[RigidBody, RigidBody]
    pivots: tuple[Array, Array]

    def aim(self, plant: MultibodyPlant, context: Context) -> None:
        """Turns cylinder and rod until each points at the other's pivot, wherever the links are."""
        ends = self.ends(plant, context)
        for i, (joint, carrier) in enumerate(zip(self.joints, self.carriers, strict=True)):
            way = ends[1 - i] - ends[i]
            R_BW = carrier.EvalPoseInWorld(context).rotation().matrix().T
            R = RotationMatrix(turn_z_to(R_BW @ way / np.linalg.norm(way)))
            joint.set_angles(context, RollPitchYaw(R).vector())

    def ends(self, plant: MultibodyPlant, context: Context) -> list[Array]:
        """Places of the pivots (3,) [m] in the world."""
        both = zip(self.carriers, self.pivots, strict=True)
        return [np.asarray(carrier.EvalPoseInWorld(context) @ pivot) for carrier, pivot in both]


def add_cylinder(plant: MultibodyPlant, robot: Robot, arm: Arm, law: CompensatorLaw) -> DrawnCylinder:
    """Adds both bodies, drawn, to a plant that has the robot's links and is not yet finalised."""
    shortest, longest = _reach(robot, arm, law)
    lengths = (0.62 * shortest, longest - 0.6 * shortest)  # of cylinder and rod: the rod never leaves
    radius = WIDTH[law.data.kind]
    carriers = (plant.GetBodyByName(arm.links[law.body]), plant.GetBodyByName(arm.links[law.arm]))
    at = pivots(arm, law)
    joints: list[BallRpyJoint] = []
    for i, (name, carrier, pivot) in enumerate(zip(NAMES, carriers, at, strict=True)):
        body = plant.AddRigidBody(name, carrier.model_instance(), SpatialInertia.Zero())
        place: Any = pivot
        X_BP = RigidTransform(place)
        frame = plant.AddFrame(FixedOffsetFrame(f"{name}_pivot", carrier.body_frame(), X_BP))
        joint: Any = plant.AddJoint(BallRpyJoint(f"{name}_joint", frame, body.body_frame()))
        joints.append(joint)
        r, length = (radius, 0.4 * radius)[i], lengths[i]
        _draw(plant, body, Cylinder(r, length), length / 2, COLOURS[law.data.kind][i], f"{name}_tube")
        _draw(plant, body, Sphere(1.1 * radius), 0.0, COLOURS[law.data.kind][i], f"{name}_eye")
    return DrawnCylinder((joints[0], joints[1]), carriers, at)


def _draw(plant: MultibodyPlant, body: RigidBody, shape: Any, height: float, rgba: Any, name: str) -> None:
    lift: Any = [0.0, 0.0, height]
    plant.RegisterVisualGeometry(body, RigidTransform(lift), shape, name, rgba)


def _reach(robot: Robot, arm: Arm, law: CompensatorLaw) -> tuple[float, float]:
    """Shortest and longest distance of the pivots [m] within the joint's limits."""
    joint = robot.joint(law.data.joint)
    q = np.zeros((50, arm.n))
    q[:, arm.names.index(joint.name)] = np.linspace(max(joint.lower, -np.pi), min(joint.upper, np.pi), 50)
    s = law.ends(frames(arm, q))[2]
    return float(s.min()), float(s.max())
