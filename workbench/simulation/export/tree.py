"""The robot as a tree of bodies and joints, as robot file formats have it.

Bodies stand in the frames of the URDF's links. At a joint the tree first has a joint for each way in which
the slot gives way beside its axis (a hinge about a line, a slide along one), then the joint itself, then its
spring.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from pydrake.multibody.tree import SpatialInertia

from ...robot.kinematics import Array
from ...robot.plant_parts import link_inertia, pivots, point_inertia, slot_pose
from ...robot.rotations import pose
from ...robot.yielding import own_compliance
from ..closed_loop.springs import SCREW_DAMPING
from .coil import nearest_coil
from .content import Content

Kind = Literal["revolute", "prismatic", "fixed"]
GROUND = "ground"  # carries a base that yields
LEAST = 1e-9  # kg, kg·m²: what some programs want at least of a body
FASTEST = 2 * np.pi * 100  # rad/s: of a drive on its spring, where the robot's TOML states no rotor inertia
NONE = 1e-12  # of the largest: a compliance that is none


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


@dataclass(frozen=True, eq=False)
class Give:
    """How a slot gives way: about (or along) `axis` (3,) through `point` (3,) [m], on the slot's axes."""

    turns: bool
    axis: Array
    point: Array
    compliance: float


def tree_of(content: Content, *, elastic: bool) -> Tree:
    """The calibrated robot, rigid or with what yields in proportion to its load."""
    arm, robot = content.arm, content.robot
    names = (*arm.links, robot.flange)
    bodies: list[Body] = []
    joints: list[Joint] = []
    parent, X_parent = GROUND, np.eye(4)
    for slot, link in enumerate(names):
        X_link = pose(np.zeros(3), arm.R_link[slot])
        placed = X_parent @ slot_pose(arm, slot, arm.geometry[slot]).GetAsMatrix4() @ X_link
        steps = _steps(content, slot, elastic)
        if slot == 0 and len(steps) == 1:
            steps = []  # nothing moves the base: it is the tree's root
        elif slot == 0:
            bodies.append(_massless(GROUND))
        for i, (name, step) in enumerate(steps):
            last = i == len(steps) - 1
            child = link if last else f"{name}_body"
            joints.append(replace(step, name=name, parent=parent, child=child, pose=placed @ step.pose))
            if not last:
                bodies.append(_massless(child, between=True))
            parent, placed = child, np.linalg.inv(step.pose)
        bodies.append(_payload(content) if slot > arm.n else _link(content, slot))
        parent, X_parent = link, X_link.T
    return Tree(robot.name, tuple(bodies), tuple(joints), coil_of(content) if elastic else None)


def _steps(content: Content, slot: int, elastic: bool) -> list[tuple[str, Joint]]:
    """The joints at a slot with their names, on the axes of the URDF's link, each where it turns."""
    arm, R = content.arm, content.arm.R_link[slot].T
    own, gives = ways(content, slot) if elastic else (0.0, [])
    out = []
    for i, give in enumerate(gives, start=1):
        kind: Kind = "revolute" if give.turns else "prismatic"
        at = pose(R @ give.point, np.eye(3))
        spring = 1 / give.compliance
        out.append(
            (
                f"{arm.slot_names[slot]}_yield_{i}",
                Joint("", kind, "", "", at, R @ give.axis, stiffness=spring, damping=SCREW_DAMPING * spring),
            )
        )
    if not 1 <= slot <= arm.n:
        name = f"{content.robot.flange}_joint" if slot else "base_joint"
        return [*out, (name, Joint("", "fixed", "", "", np.eye(4), np.zeros(3)))]
    said, axis = content.robot.joints[slot - 1], R @ [0.0, 0.0, 1.0]
    rotor, ratio = said.data.rotor_inertia, said.data.gear_ratio or 1.0
    if own and not rotor:
        rotor, ratio = 1 / own / FASTEST**2, 1.0
    drive = Joint(
        "", said.kind, "", "", np.eye(4), axis, said.lower, said.upper, said.velocity,
        rotor=rotor, ratio=ratio, driven=True,
    )  # fmt: skip
    out.append((said.name, drive))
    if own:
        yields = Joint("", said.kind, "", "", np.eye(4), axis, stiffness=1 / own, damping=said.data.damping)
        out.append((f"{said.name}_spring", yields))
    return out


def ways(content: Content, slot: int) -> tuple[float, list[Give]]:
    """A slot's compliance as springs: the joint's own [rad/(N·m), m/N], and hinges and slides for the rest.

    Turns about an axis e of the rotational part, with compliance λ, carry the slot along by C_tr e/λ, so
    about a point beside it; what is left of the translational part slides.
    """
    arm, C = content.arm, content.compliance[slot].copy()
    none = NONE * max(float(np.abs(C).max()), 1e-300)
    own = 0.0
    if 1 <= slot <= arm.n:
        k = int(arm.axial[slot - 1]) % 6
        own = own_compliance(C, k)
        own = own if own > none else 0.0
        C[k, k] -= own
    gives: list[Give] = []
    left = C[:3, :3].copy()
    values, axes = np.linalg.eigh(C[3:, 3:])
    for value, axis in zip(values, axes.T, strict=True):
        if value > none:
            along = C[:3, 3:] @ axis / value
            left -= value * np.outer(along, along)
            gives.append(Give(True, axis, np.cross(axis, along), float(value)))
    values, axes = np.linalg.eigh(left)
    slides = [Give(False, a, np.zeros(3), float(v)) for v, a in zip(values, axes.T, strict=True) if v > none]
    order = sorted([*slides, *gives], key=lambda give: (give.turns, int(np.argmax(np.abs(give.axis)))))
    return own, order


def assumed(content: Content) -> list[str]:
    """What the elastic tree had to assume, a line each."""
    joints = [
        joint.name
        for slot, joint in enumerate(content.robot.joints, start=1)
        if not joint.data.rotor_inertia and ways(content, slot)[0]
    ]
    if not joints:
        return []
    return [
        f"assumed: rotor inertia of {', '.join(joints)}, so that the drive on its spring swings at 100 Hz"
    ]


def coil_of(content: Content) -> Coil | None:
    """The compensator as a coil spring, or the nearest that there is."""
    law = nearest_coil(content)
    if law is None or law.coil is None:
        return None
    links = content.arm.links
    return Coil((links[law.body], links[law.arm]), pivots(content.arm, law), *law.coil)


def _link(content: Content, slot: int) -> Body:
    inertia = link_inertia(content.arm, slot)
    return _body(content.arm.links[slot], inertia)


def _payload(content: Content) -> Body:
    return _body(content.robot.flange, point_inertia(*content.payload))


def _body(name: str, inertia: SpatialInertia) -> Body:
    mass = inertia.get_mass()
    if mass <= 0:
        return _massless(name)
    about: Any = inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    com: Any = inertia.get_com()
    return Body(name, mass, com, about)


def _massless(name: str, *, between: bool = False) -> Body:
    return Body(name, 0.0, np.zeros(3), np.zeros((3, 3)), between)
