"""The robot to be looked at: its links wherever they are put, with what hangs on them, and its compensator.

No joint of the arm is in this plant, so that it shows a rigid arm and a yielding one alike.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context

from .compensator import compensator_law
from .cylinder import DrawnCylinder, add_cylinder
from .description import Robot
from .drake_faults import drake_reads
from .kinematics import Array
from .rigid_plant import arrays
from .shown import shown_text


@dataclass(frozen=True, eq=False)
class Picture:
    """links: base first, free bodies; cylinder: the compensator, None where there is none."""

    plant: MultibodyPlant
    links: tuple[RigidBody, ...]
    cylinder: DrawnCylinder | None

    def put(self, context: Context, poses: Array) -> None:
        """Places the links at poses (L, 4, 4) in the world; the compensator follows. context: the plant's."""
        for body, pose in zip(self.links, poses, strict=True):
            self.plant.SetFreeBodyPose(context, body, RigidTransform(pose))
        if self.cylinder is not None:
            self.cylinder.aim(self.plant, context)


def picture(robot: Robot, plant: MultibodyPlant) -> Picture:
    """Puts what there is to see of a robot into an empty plant that has a SceneGraph; finalised."""
    root = ET.fromstring(shown_text(robot))
    for joint in root.findall("joint"):
        if joint.get("name") in robot.joint_names:
            root.remove(joint)
    with drake_reads(robot):
        Parser(plant).AddModelsFromString(ET.tostring(root, encoding="unicode"), "urdf")
    arm = arrays(robot)
    law = compensator_law(robot, arm)
    cylinder = None if law is None else add_cylinder(plant, robot, arm, law)
    plant.Finalize()
    return Picture(plant, tuple(plant.GetBodyByName(link) for link in arm.links), cylinder)
