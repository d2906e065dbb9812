"""SDF: the elastic robot as plain text that Drake reads, springs, rotors and coil compensator included."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from ...files.faults import Fault, InputError
from ...robot.kinematics import Array
from ...robot.urdf import read_root
from .content import Content
from .simulated import elastic_tree
from .text import number, numbers
from .tree import LEAST, Body, Coil, Joint, Tree
from .urdf import Files, Meshes, contents, mesh_files, rpy, xml_text

DRAKE = "http://drake.mit.edu"  # the name space of Drake's own elements
DRIVES = frozenset({"revolute", "prismatic"})


def write(content: Content, header: list[str]) -> Files:
    """NAME.sdf and its meshes."""
    meshes = mesh_files(content.robot.urdf)
    root = sdf_of(content, elastic_tree(content), meshes)
    return {f"{content.robot.name}.sdf": xml_text(root, header), **contents(meshes)}


def sdf_of(content: Content, tree: Tree, meshes: Meshes) -> ET.Element:
    """The <sdf> element. Raises `InputError` where links and joints share names, which SDF does not know."""
    twice = {body.name for body in tree.bodies} & {joint.name for joint in tree.joints}
    if twice:
        what = f"a link and a joint are both called {', '.join(sorted(twice))}; in SDF no two things are"
        raise InputError(Fault(str(content.robot.urdf), what, "rename one of them there and in the TOML"))
    root = ET.Element("sdf", {"version": "1.9", "xmlns:drake": DRAKE})
    model = ET.SubElement(root, "model", {"name": tree.name})
    pictures = _pictures(content, meshes)
    placed = {joint.child: joint for joint in tree.joints}
    for body in tree.bodies:
        _link(model, body, placed.get(body.name), pictures.get(body.name, []))
    for joint in tree.joints:
        _joint(model, joint)
    if tree.coil is not None:
        _coil(model, tree.coil)
    return root


def _link(model: ET.Element, body: Body, inboard: Joint | None, pictures: list[ET.Element]) -> None:
    link = ET.SubElement(model, "link", {"name": body.name})
    if inboard is not None:
        _pose(link, np.eye(4), inboard.name)
    inertial = ET.SubElement(link, "inertial")
    _pose(inertial, _shift(body.com))
    _put(inertial, "mass", number(body.mass))
    inertia = ET.SubElement(inertial, "inertia")
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        least = LEAST if body.mass > 0 and i == j else 0.0  # SDF has no point masses
        _put(inertia, f"i{'xyz'[i]}{'xyz'[j]}", number(body.inertia[i, j] + least))
    link.extend(pictures)


def _joint(model: ET.Element, joint: Joint) -> None:
    element = ET.SubElement(model, "joint", {"name": joint.name, "type": joint.kind})
    _pose(element, joint.pose, joint.parent)
    _put(element, "parent", joint.parent)
    _put(element, "child", joint.child)
    if joint.kind not in DRIVES:
        return
    axis = ET.SubElement(element, "axis")
    _put(axis, "xyz", numbers(joint.axis))
    limit = ET.SubElement(axis, "limit")
    if np.isfinite(joint.upper - joint.lower):
        _put(limit, "lower", number(joint.lower))
        _put(limit, "upper", number(joint.upper))
    if np.isfinite(joint.velocity):
        _put(limit, "velocity", number(joint.velocity))
    if not joint.driven:
        _put(limit, "effort", "0")  # no drive
    dynamics = ET.SubElement(axis, "dynamics")
    _put(dynamics, "damping", number(joint.damping))
    if joint.stiffness is not None:
        _put(dynamics, "spring_reference", "0")
        _put(dynamics, "spring_stiffness", number(joint.stiffness))
    if joint.rotor:
        _put(element, "drake:rotor_inertia", number(joint.rotor))
        _put(element, "drake:gear_ratio", number(joint.ratio))


def _coil(model: ET.Element, coil: Coil) -> None:
    spring = ET.SubElement(model, "drake:linear_spring_damper")
    for letter, body, point in zip("AB", coil.bodies, coil.points, strict=True):
        _put(spring, f"drake:linear_spring_damper_body_{letter}", body)
        name = "drake:linear_spring_damper_p_AP" if letter == "A" else "drake:linear_spring_damper_p_BQ"
        _put(spring, name, numbers(point))
    _put(spring, "drake:linear_spring_damper_free_length", number(coil.free_length))
    _put(spring, "drake:linear_spring_damper_stiffness", number(coil.rate))
    _put(spring, "drake:linear_spring_damper_damping", "0")


def _pictures(content: Content, meshes: Meshes) -> dict[str, list[ET.Element]]:
    """The <visual>s of the URDF's links that are meshes."""
    found: dict[str, list[ET.Element]] = {}
    for link in read_root(content.robot.urdf).findall("link"):
        name = link.get("name", "")
        for i, visual in enumerate(link.findall("visual")):
            mesh, origin = visual.find("geometry/mesh"), visual.find("origin")
            if mesh is None or (written := mesh.get("filename", "")) not in meshes:
                continue
            element = ET.Element("visual", {"name": f"{name}_{i}"})
            if origin is not None:
                _put(element, "pose", f"{origin.get('xyz', '0 0 0')} {origin.get('rpy', '0 0 0')}")
            shape = ET.SubElement(ET.SubElement(element, "geometry"), "mesh")
            _put(shape, "uri", meshes[written][0])
            if mesh.get("scale"):
                _put(shape, "scale", str(mesh.get("scale")))
            found.setdefault(name, []).append(element)
    return found


def _pose(parent: ET.Element, X: Array, relative_to: str | None = None) -> None:
    element = _put(parent, "pose", f"{numbers(X[:3, 3])} {numbers(rpy(X[:3, :3]))}")
    if relative_to is not None:
        element.set("relative_to", relative_to)


def _put(parent: ET.Element, tag: str, text: str) -> ET.Element:
    element = ET.SubElement(parent, tag)
    element.text = text
    return element


def _shift(p: Array) -> Array:
    X = np.eye(4)
    X[:3, 3] = p
    return X
