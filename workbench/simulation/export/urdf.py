"""The user's own URDF with the calibrated joint origins."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...robot.kinematics import Array
from ...robot.plants import rigid_arm_plant
from ...robot.rigid_plant import rigid_twin
from ...robot.rotations import zyx_angles
from ...robot.urdf import read_root
from .content import Content
from .text import numbers, xml_comment
from .tree import tree_of

Files = Mapping[str, str | bytes]
Meshes = Mapping[str, tuple[str, Path]]
MESHES = "meshes"  # folder beside what is exported


def write(content: Content, header: list[str]) -> Files:
    """NAME.urdf and the meshes that it names by relative path. Everything else stays as the user has it."""
    robot = content.robot
    root, meshes = read_root(robot.urdf), mesh_files(robot.urdf)
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
    for mesh in root.iter("mesh"):
        if (written := mesh.get("filename", "")) in meshes:
            mesh.set("filename", meshes[written][0])
    return {f"{robot.name}.urdf": xml_text(root, header), **contents(meshes)}


def notes(content: Content) -> list[str]:
    """What else a reader must know."""
    mass = content.payload[0]
    return (
        [f"tool and payload, {mass:g} kg, are not in the file: it has the links' masses alone"]
        if mass
        else []
    )


def mesh_files(urdf: Path) -> Meshes:
    """File name as the URDF writes it → its name beside what is exported, and the file, of the meshes that
    are named by their place: one below the URDF keeps its name, one elsewhere comes into `meshes`. A name
    with a scheme, as package://, counts from anywhere."""
    names = {mesh.get("filename", "") for mesh in read_root(urdf).iter("mesh")}
    files = {name: urdf.parent / name for name in sorted(names) if name and "://" not in name}
    files = {name: file for name, file in files.items() if file.is_file()}
    found = {name: (name, file) for name, file in files.items() if _below(name)}
    for name, file in files.items():
        if not _below(name):
            free = f"{MESHES}/{file.name}"
            if free in {taken for taken, _ in found.values()}:
                free = f"{MESHES}/{len(found)}_{file.name}"
            found[name] = free, file
    return found


def contents(meshes: Meshes) -> dict[str, bytes]:
    """The mesh files by their names beside what is exported."""
    return {name: file.read_bytes() for name, file in meshes.values()}


def _below(name: str) -> bool:
    return not (Path(name).is_absolute() or ".." in Path(name).parts)


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
