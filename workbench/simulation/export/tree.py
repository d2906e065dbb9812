"""The robot as a tree of bodies and joints, as robot file formats have it.

It is written down from the Drake plant that `verify` simulates. Bodies stand in the frames of the URDF's
links. At a joint the tree first has a joint for each way in which the slot gives way beside its axis (a hinge
about a line, a slide along one), then the joint itself, then its spring.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.tree import Joint as DrakeJoint
from pydrake.multibody.tree import PrismaticJoint, RevoluteJoint, RigidBody, WeldJoint

from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.plants import ArmPlant

Kind = Literal["revolute", "prismatic", "fixed"]
GROUND = "ground"  # carries a base that yields
LOAD = "tool_and_payload"  # on a flange that is itself a moving link
LEAST = 1e-9  # kg, kg·m²: what some programs want at least of a body


@dataclass(frozen=True, eq=False)
class Body:
    """mass [kg], com: (3,) [m], inertia: (3, 3) [kg·m²] about the centre of mass, on the body's axes.

    between: it is no link, but stands between two joints and has no mass.
    """

    name: str
    mass: float
    com: Array
    inertia: Array
    between: bool = False


@dataclass(frozen=True, eq=False)
class Joint:
    """From parent to child. pose: (4, 4) of the joint in the parent; the child's frame is the joint's own.

    axis: (3,) in the joint's frame. stiffness: of a spring that is slack at zero, None for a driven joint.
    rotor: inertia on the motor's side, with `ratio`. damping: [N·m·s/rad].
    """

    name: str
    kind: Kind
    parent: str
    child: str
    pose: Array
    axis: Array
    lower: float = -np.inf
    upper: float = np.inf
    velocity: float = np.inf
    stiffness: float | None = None
    damping: float = 0.0
    rotor: float = 0.0
    ratio: float = 1.0
    driven: bool = False


@dataclass(frozen=True, eq=False)
class Coil:
    """A spring between points of two bodies: (3,) [m] each; rate [N/m], free length [m]."""

    bodies: tuple[str, str]
    points: tuple[Array, Array]
    rate: float
    free_length: float


@dataclass(frozen=True, eq=False)
class Tree:
    """Bodies, base first, and joints in their order; coil: the compensator's spring."""

    name: str
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    coil: Coil | None = None


def tree_of(robot: Robot, built: ArmPlant, springs: Mapping[str, float] | None = None) -> Tree:
    """The bodies and joints of a plant: the robot's links, and its tool and payload as its flange.

    springs: joint → stiffness [N·m/rad, N/m].
    """
    reading = _Reading(robot, built, springs or {})
    reading.behind(built.plant.world_body(), None, RigidTransform())
    coil, names = None, reading.names
    if (spring := built.coil) is not None:
        points: Any = spring.p_AP(), spring.p_BQ()
        ends = names[spring.bodyA().index()], names[spring.bodyB().index()]
        coil = Coil(ends, points, spring.stiffness(), spring.free_length())
    return Tree(robot.name, tuple(reading.bodies), tuple(reading.joints), coil)


class _Reading:
    """Bodies and joints as they are found from the base on."""

    def __init__(self, robot: Robot, built: ArmPlant, springs: Mapping[str, float]) -> None:
        self.robot, self.springs = robot, springs
        links = [body.name() for body in built.bodies[:-1]]
        names = [*links, LOAD if robot.flange in links else robot.flange]
        self.names = dict(zip((body.index() for body in built.bodies), names, strict=True))
        self.carried = {body.index() for body in built.bodies[1:-1]}  # by a joint of the robot, or its spring
        plant = built.plant
        self.rotors = {
            (actuator := plant.get_joint_actuator(i)).joint().index(): (
                actuator.default_rotor_inertia(),
                actuator.default_gear_ratio(),
            )
            for i in plant.GetJointActuatorIndices()
        }
        self.outboard: dict[Any, list[DrakeJoint]] = {}
        for i in plant.GetJointIndices():
            joint = plant.get_joint(i)
            self.outboard.setdefault(joint.parent_body().index(), []).append(joint)
        self.bodies: list[Body] = []
        self.joints: list[Joint] = []

    def behind(self, body: RigidBody, name: str | None, X_BT: RigidTransform) -> None:
        """Notes what a body carries. name: the body's in the tree, None for one that is not in it; X_BT: its
        frame in the tree."""
        for joint in self.outboard.get(body.index(), []):
            child = joint.child_body()
            if name is None and isinstance(joint, WeldJoint):  # nothing moves the base: it is the tree's root
                self.bodies.append(_body(self.names[child.index()], child))
                self.behind(child, self.bodies[-1].name, RigidTransform())
                continue
            if name is None:
                name = GROUND
                self.bodies.append(_massless(GROUND))
            self._joint(joint, child, name, X_BT)

    def _joint(self, joint: DrakeJoint, child: RigidBody, parent: str, X_BT: RigidTransform) -> None:
        X_BF = joint.frame_on_parent().GetFixedPoseInBodyFrame()
        X_CM = joint.frame_on_child().GetFixedPoseInBodyFrame()
        carried, X_CL = self._carried(child)
        said = self.names.get((carried or child).index())
        if said is None:  # it stands between two joints, in the frame of the first
            there = _massless(child.name(), between=True)
            X_CT = X_CM
        else:
            there, X_CT = _body(said, carried or child), X_CL
        pose = X_BT.inverse() @ X_BF @ X_CM.inverse() @ X_CT
        turn = (X_CT.inverse() @ X_CM).rotation()
        self.bodies.append(there)
        self.joints.append(self._written(joint, parent, there.name, pose.GetAsMatrix4(), turn))
        self.behind(carried or child, there.name, RigidTransform() if said else X_CT)

    def _carried(self, body: RigidBody) -> tuple[RigidBody | None, RigidTransform]:
        """The link that a body without mass is welded to, at its joint, and the link's pose in it."""
        for joint in self.outboard.get(body.index(), []):
            if isinstance(joint, WeldJoint) and joint.child_body().index() in self.carried:
                X_LM = joint.frame_on_child().GetFixedPoseInBodyFrame()
                X_BF = joint.frame_on_parent().GetFixedPoseInBodyFrame()
                return joint.child_body(), X_BF @ joint.X_FM() @ X_LM.inverse()
        return None, RigidTransform()

    def _written(self, joint: DrakeJoint, parent: str, child: str, pose: Array, turn: Any) -> Joint:
        if isinstance(joint, WeldJoint):
            name = "base_joint" if child == self.robot.base else f"{child}_joint"
            return Joint(name, "fixed", parent, child, pose, np.zeros(3))
        kind: Kind = "revolute" if isinstance(joint, RevoluteJoint) else "prismatic"
        assert isinstance(joint, RevoluteJoint | PrismaticJoint)
        along = joint.revolute_axis() if isinstance(joint, RevoluteJoint) else joint.translation_axis()
        axis = np.asarray(turn @ along)
        rotor, ratio = self.rotors.get(joint.index(), (0.0, 1.0))
        damping, stiffness = joint.default_damping(), self.springs.get(joint.name())
        if joint.name() not in self.robot.joint_names:
            return Joint(joint.name(), kind, parent, child, pose, axis, stiffness=stiffness, damping=damping)
        own = self.robot.joint(joint.name())
        return Joint(
            own.name, kind, parent, child, pose, axis, own.lower, own.upper, own.velocity,
            rotor=rotor, ratio=ratio, driven=True,
        )  # fmt: skip


def _body(name: str, body: RigidBody) -> Body:
    inertia = body.default_spatial_inertia()
    mass = inertia.get_mass()
    if mass <= 0:
        return _massless(name)
    about: Any = inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    com: Any = inertia.get_com()
    return Body(name, mass, com, about)


def _massless(name: str, *, between: bool = False) -> Body:
    return Body(name, 0.0, np.zeros(3), np.zeros((3, 3)), between)
