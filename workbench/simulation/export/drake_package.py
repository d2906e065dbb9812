"""A package for Drake: SDF, model directives, and a module that adds the robot with its effects."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...effects.acting import Acting
from ...robot.kinematics import Array
from ...robot.plant_parts import pivots
from .content import Content, Part
from .sdf import sdf_of
from .text import commented
from .tree import tree_of, ways
from .urdf import Files, mesh_files, xml_text

MODULE = Path(__file__).with_name("extended_robot.py")
SAMPLES = 2001  # of a curve over a joint's range, at least
PER_PERIOD = 60  # samples, of an error with an order

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
    """package.xml, NAME.dmd.yaml, NAME.sdf, extended_robot.py, effects.npz and the meshes."""
    name, tree, law = content.robot.name, tree_of(content, elastic=True), content.compensator
    if law is not None and law.coil is None:
        tree = replace(tree, coil=None)
    meshes = mesh_files(content.robot.urdf)
    root = sdf_of(content, tree, meshes)
    texts: dict[str, str | bytes] = {
        "package.xml": PACKAGE.format(name=name, title=content.robot.title.replace("&", "&amp;")),
        f"{name}.dmd.yaml": commented(header) + DIRECTIVES.format(name=name, root=tree.bodies[0].name),
        f"{name}.sdf": xml_text(root, header),
        "extended_robot.py": commented(header) + MODULE.read_text(encoding="utf-8"),
        "effects.npz": effects(content),
    }
    return texts | {mesh: path.read_bytes() for mesh, path in meshes.items()}


def effects(content: Content) -> bytes:
    """What SDF cannot say, as `extended_robot` reads it."""
    robot, arm, law = content.robot, content.arm, content.compensator
    own = np.array([ways(content, slot)[0] for slot in range(1, arm.n + 1)])
    data: dict[str, Any] = {
        "name": robot.name,
        "joints": list(robot.joint_names),
        "flange": robot.flange,
        "gravity": np.array(robot.gravity),
        "stiffness": np.divide(1.0, own, out=np.zeros(arm.n), where=own > 0),
        "damping": np.array([joint.data.damping for joint in robot.joints]),
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
                for (j, k), curve in curves(content, item, kind).items():
                    data[f"{kind}/{j}/{k}/{i}"] = curve
    file = io.BytesIO()
    np.savez_compressed(file, **data)
    return file.getvalue()


def curves(content: Content, item: Part, kind: str) -> dict[tuple[int, int], Array]:
    """(joint, joint that it depends on) → (2, M) the latter's positions, and the error or torque there.

    The parts of one effect add up over the joints; what they share at zero goes with the first.
    """
    arm, robot = content.arm, content.robot
    order = item[0].where.order or 0.0
    out: dict[tuple[int, int], Array] = {}
    rest = _at(content, item, kind, np.zeros((1, arm.n)))[0]
    for k, joint in enumerate(robot.joints):
        low, high = max(joint.lower, -2 * np.pi), min(joint.upper, 2 * np.pi)
        count = max(SAMPLES, int(PER_PERIOD * order * (high - low) / (2 * np.pi)))
        q = np.zeros((count, arm.n))
        q[:, k] = np.linspace(low, high, count)
        values = _at(content, item, kind, q)
        for j in np.flatnonzero((np.ptp(values, axis=0) > 0) | ((k == arm.n - 1) & (rest != 0))):
            out[int(j), k] = np.stack([q[:, k], values[:, j] - rest[j]])
    for j in np.flatnonzero(rest):
        first = min(key for key in out if key[0] == j)
        out[first][1] += rest[j]
    return out


def _at(content: Content, item: Part, kind: str, q: Array) -> Array:
    """(M, n) error [rad, m] or torque [N·m, N] of each joint at joints q (M, n)."""
    alone = Acting((item,))
    if kind == "gear":
        return alone.gear_error(q, None, content.arm.names)
    some = np.zeros(len(q), dtype=np.int64)
    there = content.extended.at(q, None, some)
    return alone.loads(there, content.arm)[1].torque
