"""The user's own URDF with the calibrated joint origins."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.meshes import GLTF, HOW, obj_of_gltf
from ...robot.plants import rigid_arm_plant
from ...robot.rigid_plant import rigid_twin
from ...robot.rotations import zyx_angles
from ...robot.urdf import read_root
from .content import Content
from .text import numbers, xml_comment
from .tree import tree_of

Files = Mapping[str, str | bytes]
Meshes = Mapping[str, tuple[str, Mapping[str, bytes]]]
MESHES = "meshes"  # folder beside what is exported


def write(content: Content, header: list[str]) -> Files:
    """NAME.urdf and the meshes that it names by relative path. Everything else stays as the user has it."""
    robot = content.robot
    root, meshes = read_root(robot.urdf), mesh_files(robot.urdf)
    nominal = rigid_twin(robot)
    elements = {joint.get("name"): joint for joint in root.findall("joint")}
    carries = {name: elements[name] for name in robot.joint_names}
    to_flange = _to_flange(root, robot)
    for joint in tree_of(robot, rigid_arm_plant(content.arm)).joints:
        element = carries.get(joint.name)
        if element is None and joint.child == robot.flange and content.arm.geometry[-1].any():
            element = to_flange
        if element is None:
            continue
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


def has_flange(content: Content) -> bool:
    """Whether the file has a frame that says how the flange stands on the last axis: not where that is the
    last link's own."""
    return _to_flange(read_root(content.robot.urdf), content.robot) is not None


def _to_flange(root: ET.Element, robot: Robot) -> ET.Element | None:
    """The fixed joint that carries the flange."""
    for element in root.findall("joint"):
        child = element.find("child")
        if child is not None and child.get("link") == robot.flange and element.get("type") == "fixed":
            return element
    return None


def notes(content: Content) -> list[str]:
    """What else a reader must know."""
    mass = content.payload[0]
    told = f"tool and payload, {mass:g} kg, are not in the file: it has the links' masses alone"
    return [*([told] if mass else []), *mesh_notes(content)]


def mesh_notes(content: Content) -> list[str]:
    """A note on meshes that many programs do not read."""
    left = [name for name, _ in mesh_files(content.robot.urdf).values() if Path(name).suffix.lower() in GLTF]
    said = f"meshes in glTF ({left[0]} ...) are for Drake, others want OBJ: {HOW} writes it" if left else ""
    return [said] if left else []


def mesh_files(urdf: Path) -> Meshes:
    """File name as the URDF writes it → its name beside what is exported, and the files behind it by their
    names there, of the meshes that are named by their place: one below the URDF keeps its name, one elsewhere
    comes into `meshes`. glTF becomes OBJ. A name with a scheme, as package://, counts from anywhere."""
    names = {mesh.get("filename", "") for mesh in read_root(urdf).iter("mesh")}
    files = {name: urdf.parent / name for name in sorted(names) if name and "://" not in name}
    files = {name: file for name, file in files.items() if file.is_file()}
    beside = {name: name for name in files if _below(name)}
    for name, file in files.items():
        if not _below(name):
            free = f"{MESHES}/{file.name}"
            beside[name] = free if free not in beside.values() else f"{MESHES}/{len(beside)}_{file.name}"
    return {name: _read(file, beside[name], {*beside.values()}) for name, file in files.items()}


def _read(file: Path, name: str, taken: set[str]) -> tuple[str, Mapping[str, bytes]]:
    """A mesh's name beside what is exported, and the files behind it. taken: the names of all."""
    place = Path(name)
    if place.suffix.lower() in GLTF:
        stem = place.with_suffix("") if place.with_suffix(".obj").as_posix() not in taken else place
        mtl = f"{stem.name}.mtl"
        if found := obj_of_gltf(file, mtl):
            obj = stem.with_name(f"{stem.name}.obj").as_posix()
            return obj, {obj: found[0].encode(), stem.with_name(mtl).as_posix(): found[1].encode()}
    return name, {name: file.read_bytes()}


def contents(meshes: Meshes) -> dict[str, bytes]:
    """The mesh files by their names beside what is exported."""
    return {name: data for _, files in meshes.values() for name, data in files.items()}


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
