"""A robot as the world publishes it: a ROS package under another folder name, xacro'd, with STL and DAE."""

from __future__ import annotations

import struct
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

AXES = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")
PLACES = ("0 0 0.18", "0.15 0.01 0.2", "0 0 0.7", "0.1 0 0.12", "0.55 0 0", "0.12 0 0")
NAMES = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
MASSES = (12.0, 9.0, 6.0, 3.0, 2.0, 0.6)
TURN = "0 1.5707963267948966 0"  # of the flange: z out


def stl(path: Path, facets: int = 12) -> None:
    """A cone of so many facets, binary."""
    angle = np.linspace(0, 2 * np.pi, facets + 1)
    ring = 0.08 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    top = np.array([0.0, 0.0, 0.3])
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        file.write(b"\0" * 80 + struct.pack("<I", facets))
        for a, b in pairwise(ring):
            file.write(struct.pack("<12fH", 0, 0, 0, *a, *b, *top, 0))


def dae(path: Path) -> None:
    """A red tetrahedron in COLLADA, in inches."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>
<unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="red-fx"><profile_COMMON><technique sid="common"><lambert>
<diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="red"><instance_effect url="#red-fx"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="pa" count="12">0 0 0 10 0 0 0 10 0 0 0 10</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4" material="m"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="m" target="#red"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>""")


def mesh(kind: str, filename: str) -> str:
    return f'<{kind}><geometry><mesh filename="{filename}"/></geometry></{kind}>'


def arm(prefix: str = "", package: str = "acme_description", mount: str = "world", xyz: str = "0 0 0",
        rpy: str = "0 0 0", kind: str = "fixed") -> str:  # fmt: skip
    """Links and joints of one arm: base_link behind a `kind` joint on `mount`, ..., flange, tool0."""
    parts = [
        f'<link name="{prefix}base_link"/>',
        f'<joint name="{prefix}mount" type="{kind}"><parent link="{mount}"/><child link="{prefix}base_link"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/></joint>',
    ]
    parent = f"{prefix}base_link"
    for i, name in enumerate(NAMES):
        link = f"{prefix}{name}_link"
        seen = f"package://{package}/meshes/{'cone.stl' if i % 2 else 'part.dae'}"
        turning = "continuous" if i == 5 else "revolute"
        limit = '<limit effort="90" velocity="2"' + (' lower="-3" upper="3"/>' if i < 5 else "/>")
        parts += [
            f'<link name="{link}">{mesh("visual", seen)}{mesh("collision", seen)}'
            f'<inertial><origin xyz="0.05 0 0.1"/><mass value="{MASSES[i]}"/>'
            '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>',
            f'<joint name="{prefix}{name}_joint" type="{turning}"><parent link="{parent}"/>'
            f'<child link="{link}"/><origin xyz="{PLACES[i]}"/><axis xyz="{AXES[i]}"/>{limit}'
            '<safety_controller k_velocity="0"/></joint>'
            f'<transmission name="{prefix}{name}_drive"><type>simple</type></transmission>',
        ]
        parent = link
    for child, name, turn in ((parent, "flange", "0 0 0"), (f"{prefix}flange", "tool0", TURN)):
        parts.append(
            f'<link name="{prefix}{name}"/><joint name="{prefix}{name}_fix" type="fixed">'
            f'<parent link="{child}"/><child link="{prefix}{name}"/><origin rpy="{turn}"/></joint>'
        )
    return "\n".join(parts)


def gripper(prefix: str = "") -> str:
    """Two fingers on the flange, of which one follows the other."""
    slide = '<axis xyz="0 1 0"/><limit lower="0" upper="0.04"/>'
    return (
        f'<link name="{prefix}f1"/><link name="{prefix}f2"/>'
        f'<joint name="{prefix}finger_1" type="prismatic"><parent link="{prefix}flange"/>'
        f'<child link="{prefix}f1"/>{slide}</joint><joint name="{prefix}finger_2" type="prismatic">'
        f'<parent link="{prefix}flange"/><child link="{prefix}f2"/>'
        f'{slide}<mimic joint="{prefix}finger_1"/></joint>'
    )


def robot(inner: str, root: str = "world") -> str:
    return f'<robot name="acme">\n<link name="{root}"/>\n{inner}\n</robot>\n'


def package(folder: Path, name: str = "acme_description") -> Path:
    """A package as cloned, under another folder name; the path of its URDF."""
    (folder / "urdf").mkdir(parents=True)
    (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")
    stl(folder / "meshes/cone.stl")
    dae(folder / "meshes/part.dae")
    (folder / "urdf/acme.urdf").write_text(robot(arm() + gripper()))
    return folder / "urdf/acme.urdf"


def flange_place(q: np.ndarray) -> np.ndarray:
    """(3,) [m] of the flange in base_link at joints q (6,), by hand."""
    R, p = np.eye(3), np.zeros(3)
    for axis, place, angle in zip(AXES, PLACES, q, strict=True):
        p = p + R @ np.array(place.split(), dtype=float)
        R = R @ Rotation.from_rotvec(angle * np.array(axis.split(), dtype=float)).as_matrix()
    return p
