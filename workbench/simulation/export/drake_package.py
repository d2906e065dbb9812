"""A package for Drake: SDF, model directives, and a module that adds the robot with its effects."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from ...effects.acting import Acting
from ...robot import extended_robot
from ...robot.kinematics import Array
from ...robot.plant_parts import pivots
from ..gear_curves import curves
from .content import Content, Part
from .sdf import sdf_of
from .simulated import Simulated, simulated
from .text import commented
from .urdf import Files, contents, mesh_files, xml_text

MODULE = Path(extended_robot.__file__).parent

PACKAGE = """<?xml version="1.0"?>
<package format="2">
  <name>{name}</name>
  <version>1.0.0</version>
  <description>{title}</description>
  <maintainer email="nobody@localhost">nobody</maintainer>
  <license>as the robot's own description</license>
</package>
"""
DIRECTIVES = """directives:
- add_model:
    name: {name}
    file: package://{name}/{name}.sdf
- add_weld:
    parent: world
    child: {name}::{root}
"""


def write(content: Content, header: list[str]) -> Files:
    """package.xml, NAME.dmd.yaml, NAME.sdf, extended_robot/, effects.npz and the meshes."""
    name, whole = content.robot.name, simulated(content, content.compensator)
    tree, meshes = whole.tree(content.robot), mesh_files(content.robot.urdf)
    root = sdf_of(content, tree, meshes)
    files: dict[str, str | bytes] = {
        "package.xml": PACKAGE.format(name=name, title=content.robot.title.replace("&", "&amp;")),
        f"{name}.dmd.yaml": commented(header) + DIRECTIVES.format(name=name, root=tree.bodies[0].name),
        f"{name}.sdf": xml_text(root, header),
        "effects.npz": effects(content, whole),
    }
    for file in sorted(MODULE.glob("*.py")):
        said = commented(header) if file.stem == "__init__" else ""
        files[f"{MODULE.name}/{file.name}"] = said + file.read_text(encoding="utf-8")
    return files | contents(meshes)


def effects(content: Content, whole: Simulated) -> bytes:
    """What SDF cannot say, as `extended_robot` reads it."""
    robot, arm, law, built = content.robot, content.arm, content.compensator, whole.machine
    springs = np.zeros((2, arm.n))
    springs[:, built.sprung] = [array[: len(built.sprung)] for array in (built.stiffness, built.damping)]
    data: dict[str, Any] = {
        "name": robot.name,
        "joints": list(robot.joint_names),
        "flange": robot.flange,
        "gravity": np.array(robot.gravity),
        "stiffness": springs[0],
        "damping": springs[1],
    }
    if law is not None and law.coil is None:
        d = law.data
        gas = (d.piston_area, law.charge, law.preload, d.precharge, d.gas_length, d.reference, d.exponent)
        data["gas"] = np.array(gas, dtype=np.float64)
        data["gas_bodies"] = [arm.links[law.body], arm.links[law.arm]]
        data["gas_pivots"] = np.array(pivots(arm, law))
    for kind in ("gear", "torque"):
        for i, (item, found) in enumerate(zip(content.extended.acting, content.kinds, strict=True)):
            if found == kind:
                for (j, k), curve in _curves(content, item, kind).items():
                    data[f"{kind}/{j}/{k}/{i}"] = curve
    file = io.BytesIO()
    np.savez_compressed(file, **data)
    return file.getvalue()


def _curves(content: Content, item: Part, kind: str) -> dict[tuple[int, int], Array]:
    """The curves of one effect over the joints' ranges; what they share at zero goes with the last."""
    turn = np.where(np.isfinite(content.robot.limits) & content.arm.prismatic[:, None], np.inf, 2 * np.pi)
    ends = np.clip(content.robot.limits, -turn, turn)

    def values(q: Array) -> Array:
        return _at(content, item, kind, q)

    order = item[0].where.order or 0.0
    rest, out = curves(values, np.zeros(content.arm.n), ends[:, 0], ends[:, 1], order)
    for j in np.flatnonzero(rest).tolist():
        last = (j, content.arm.n - 1)
        out.setdefault(last, np.stack([np.linspace(ends[-1, 0], ends[-1, 1], 3), np.zeros(3)]))[1] += rest[j]
    return out


def _at(content: Content, item: Part, kind: str, q: Array) -> Array:
    """(M, n) error [rad, m] or torque [N·m, N] of each joint at joints q (M, n)."""
    alone = Acting((item,))
    if kind == "gear":
        return alone.gear_error(q, None, content.arm.names)
    some = np.zeros(len(q), dtype=np.int64)
    there = content.extended.at(q, None, some)
    return alone.loads(there, content.arm)[1].torque
