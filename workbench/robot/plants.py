"""Drake plants of a robot: every plant of the workbench is built here.

`urdf_plant` is the URDF as Drake reads it: the rigid twin. `arm_plant` has the same links, with the same
names, frames and masses, from the arrays that were taken from that plant; between each slot and its link it
lets the caller put what moves there (`plant_parts`): a joint, a motor and a spring, screws. `picture` shows
the links of either.
So corrected lengths, changed masses and whatever yields come into one chain, and nothing is said twice.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, Frame, LinearSpringDamper, RigidBody, SpatialInertia

from .compensator import CompensatorLaw
from .description import Robot
from .drake_faults import drake_reads
from .kinematics import Arm, Array
from .plant_parts import add_coil, axial_joint, link_inertia, motion_transform, slot_pose
from .shown import bare_text

Moving = Callable[[MultibodyPlant, int, Frame], Frame]


def urdf_plant(
    robot: Robot,
    plant: MultibodyPlant | None = None,
    more: Callable[[MultibodyPlant], None] | None = None,
) -> MultibodyPlant:
    """The robot's URDF in Drake, base welded to the world, gravity as the TOML says; finalised.

    plant: an empty one that is part of a diagram already. more: adds to it what the URDF does not have.
    """
    plant = MultibodyPlant(0.0) if plant is None else plant
    with drake_reads(robot):
        Parser(plant).AddModelsFromString(bare_text(robot), "urdf")
        for name in robot.joint_names:  # Drake skips some elements that it does not understand
            plant.GetJointByName(name)
    plant.mutable_gravity_field().set_gravity_vector(np.array(robot.gravity))
    plant.WeldFrames(plant.world_frame(), plant.GetBodyByName(robot.base).body_frame())
    if more is not None:
        more(plant)
    plant.Finalize()
    return plant


@dataclass(frozen=True, eq=False)
class ArmPlant:
    """A plant that was built from an arm's arrays.

    bodies: base, links (named and placed as in the URDF), then "tool and payload" at the flange.
    slots: (S,) frames L behind the slots, as `kinematics` has them. corrected: (S,) frames at the slots with
    their corrections G, in the frame behind the slot before. coil: the compensator's.
    """

    plant: MultibodyPlant
    bodies: tuple[RigidBody, ...]
    slots: tuple[Frame, ...]
    corrected: tuple[FixedOffsetFrame, ...]
    coil: LinearSpringDamper | None = None


def arm_plant(
    arm: Arm,
    moving: Moving,
    payload: SpatialInertia | None = None,
    placed: Array | None = None,
    compensator: CompensatorLaw | None = None,
) -> ArmPlant:
    """Builds an arm slot by slot; finalised.

    moving: adds what moves at a slot, on the frame given, and returns the frame that carries the link.
    payload: inertia of tool and payload in the flange's frame. placed: (S, 6) motions that stay as they are.
    compensator: whose coil spring becomes Drake's element; of another law, see `plant_diagram`.
    """
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(arm.gravity)
    bodies: list[RigidBody] = []
    slots: list[Frame] = []
    corrected: list[FixedOffsetFrame] = []
    parent: Frame = plant.world_frame()
    for slot, name in enumerate(arm.slot_names):
        X = slot_pose(arm, slot, arm.geometry[slot])
        if placed is not None:
            X = X @ motion_transform(placed[slot])
        frame = plant.AddFrame(FixedOffsetFrame(f"{name}_geometry", parent, X))
        carrying = moving(plant, slot, frame)
        link = arm.links[slot] if slot <= arm.n else "tool and payload"
        inertia = link_inertia(arm, slot) if slot <= arm.n else payload or SpatialInertia.Zero()
        body = plant.AddRigidBody(link, inertia)
        X_BL = RigidTransform(RotationMatrix(arm.R_link[slot].T))
        parent = plant.AddFrame(FixedOffsetFrame(f"{link}_slot", body.body_frame(), X_BL))
        plant.WeldFrames(carrying, parent)
        bodies.append(body)
        slots.append(parent)
        corrected.append(frame)
    coil = None
    if compensator is not None and compensator.coil is not None:
        coil = add_coil(plant, tuple(bodies), arm, compensator)
    plant.Finalize()
    return ArmPlant(plant, tuple(bodies), tuple(slots), tuple(corrected), coil)


def rigid_arm_plant(arm: Arm, payload: SpatialInertia | None = None) -> ArmPlant:
    """The arm with its joints alone, each under its own name."""

    def moving(plant: MultibodyPlant, slot: int, frame: Frame) -> Frame:
        if not 1 <= slot <= arm.n:
            return frame
        return axial_joint(plant, arm, slot, arm.names[slot - 1], frame).child_body().body_frame()

    return arm_plant(arm, moving, payload)
