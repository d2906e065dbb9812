"""MJCF: the elastic robot for MuJoCo. Several joints may sit in one body, so none without mass is needed."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from ...robot.kinematics import Array
from ...robot.rotations import quaternions
from .content import Content
from .simulated import elastic_tree
from .text import number, numbers
from .tree import LEAST, Body, Coil, Joint
from .urdf import Files, xml_text

TIMESTEP = 5e-4  # s: at MuJoCo's own 2 ms a light wrist on stiff springs diverges
KINDS = {"revolute": "hinge", "prismatic": "slide"}


def write(content: Content, header: list[str]) -> Files:
    """NAME.xml. Pictures are left out: MuJoCo reads no glTF."""
    tree = elastic_tree(content)
    root = ET.Element("mujoco", {"model": tree.name})
    ET.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true"})
    option = {"gravity": numbers(content.arm.gravity), "timestep": number(TIMESTEP)}
    ET.SubElement(root, "option", option)
    world = ET.SubElement(root, "worldbody")
    bodies = {body.name: body for body in tree.bodies}
    ground = tree.bodies[0]
    held = {ground.name: _body(world, ground, np.eye(4), moves=False)}
    chain: list[tuple[Joint, Array]] = []  # joints since the last link, and where each turns in it
    for joint in tree.joints:
        chain.append((joint, (chain[-1][1] if chain else np.eye(4)) @ joint.pose))
        body = bodies[joint.child]
        if body.between:
            continue
        X = chain[-1][1]
        moving = [(one, np.linalg.inv(X) @ where) for one, where in chain if one.kind != "fixed"]
        held[body.name] = _body(held[chain[0][0].parent], body, X, moves=bool(moving))
        for one, where in moving:
            _joint(held[body.name], one, where)
        chain = []
    if tree.coil is not None:
        _coil(root, held, tree.coil)
    actuators = ET.SubElement(root, "actuator")
    for joint in tree.joints:
        if joint.driven:
            ET.SubElement(actuators, "motor", {"name": joint.name, "joint": joint.name})
    return {f"{content.robot.name}.xml": xml_text(root, header)}


def _body(parent: ET.Element, body: Body, X: Array, *, moves: bool) -> ET.Element:
    w = quaternions(X[None, :3, :3])[0]
    element = ET.SubElement(parent, "body", {"name": body.name, "pos": numbers(X[:3, 3]), "quat": numbers(w)})
    mass, inertia = body.mass, body.inertia
    if mass <= 0 and moves:
        mass, inertia = LEAST, LEAST * np.eye(3)
    if mass > 0:
        i = inertia + LEAST * np.eye(3)
        values = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
        said = {"pos": numbers(body.com), "mass": number(mass), "fullinertia": numbers(values)}
        ET.SubElement(element, "inertial", said)
    return element


def _joint(body: ET.Element, joint: Joint, X: Array) -> None:
    """A joint at pose X (4, 4) in its body, all joints at zero."""
    said = {"name": joint.name, "type": KINDS[joint.kind], "pos": numbers(X[:3, 3])}
    said["axis"] = numbers(X[:3, :3] @ joint.axis)
    if joint.stiffness is not None:
        said |= {"stiffness": number(joint.stiffness), "damping": number(joint.damping)}
    if joint.rotor:
        said["armature"] = number(joint.rotor * joint.ratio**2)
    if np.isfinite(joint.upper - joint.lower):
        said["range"] = numbers([joint.lower, joint.upper])
    ET.SubElement(body, "joint", said)


def _coil(root: ET.Element, held: dict[str, ET.Element], coil: Coil) -> None:
    tendon = ET.SubElement(root, "tendon")
    said = {"name": "compensator", "stiffness": number(coil.rate), "springlength": number(coil.free_length)}
    spatial = ET.SubElement(tendon, "spatial", said)
    for body, point in zip(coil.bodies, coil.points, strict=True):
        name = f"compensator_on_{body}"
        ET.SubElement(held[body], "site", {"name": name, "pos": numbers(point)})
        ET.SubElement(spatial, "site", {"site": name})
