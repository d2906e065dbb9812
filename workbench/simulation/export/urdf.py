"""The user's own URDF with the calibrated joint origins."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...files.faults import read_text
from ...robot.kinematics import Array
from ...robot.plants import rigid_arm_plant
from ...robot.rigid_plant import rigid_twin
from ...robot.rotations import zyx_angles
from ...robot.urdf import xml_root
from .content import Content
from .text import numbers, xml_comment
from .tree import tree_of

Files = Mapping[str, str | bytes]


def write(content: Content, header: list[str]) -> Files:
    """NAME.urdf and the meshes that it names by relative path. Everything else stays as the user has it."""
    robot = content.robot
    root = xml_root(read_text(robot.urdf), robot.urdf)
    nominal = rigid_twin(robot)
    for joint in tree_of(robot, rigid_arm_plant(content.arm)).joints:
        if joint.name not in robot.joint_names:
            continue
        (element,) = (e for e in root.findall("joint") if e.get("name") == joint.name)
        parent = element.find("parent")
        assert parent is not None
        before = nominal.plant.GetBodyByName(parent.get("link", "")).body_frame()
        carrier = nominal.plant.GetBodyByName(joint.parent).body_frame()
        X = before.CalcPose(nominal.context, carrier).inverse().GetAsMatrix4() @ joint.pose
        _place(element, X)
    meshes = {name: path.read_bytes() for name, path in mesh_files(robot.urdf).items()}
    return {f"{robot.name}.urdf": xml_text(root, header), **meshes}


def notes(content: Content) -> list[str]:
    """What else a reader must know."""
    mass = content.payload[0]
    return (
        [f"tool and payload, {mass:g} kg, are not in the file: it has the links' masses alone"]
        if mass
        else []
    )


def mesh_files(urdf: Path) -> dict[str, Path]:
    """File name as the URDF writes it → the file, of the meshes beside it."""
    root = xml_root(read_text(urdf), urdf)
    names = {mesh.get("filename", "") for mesh in root.iter("mesh")}
    found = {}
    for name in sorted(names):
        if "://" not in name and ".." not in Path(name).parts and (urdf.parent / name).is_file():
            found[name] = urdf.parent / name
    return found


def xml_text(root: ET.Element, header: list[str]) -> str:
    """The file: the header as a comment, then the element."""
    ET.indent(root)
    return f'<?xml version="1.0"?>\n{xml_comment(header)}\n{ET.tostring(root, encoding="unicode")}\n'


def _place(joint: ET.Element, X: Array) -> None:
    """Writes a joint's origin."""
    origin = joint.find("origin")
    if origin is None:
        origin = ET.SubElement(joint, "origin")
    origin.set("xyz", numbers(X[:3, 3]))
    origin.set("rpy", numbers(rpy(X[:3, :3])))


def rpy(R: Array) -> Array:
    """(3,) roll, pitch, yaw [rad] of a rotation (3, 3)."""
    return np.asarray(zyx_angles(R[None])[0, ::-1])
