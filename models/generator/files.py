"""Writes a design as URDF and TOML. Same design, same bytes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from workbench.robot.schema import STANDARD_GRAVITY

from .design import LOOP, Design, Mass
from .kinematics import Array, pose, rotation_x, rotation_y, rotation_z
from .mesh import Shape, gltf

HEADER = "Written by models/make_models.py; edit there, not here."


def write(design: Design, folder: Path) -> list[Path]:
    """Write `<name>.urdf`, `<name>.toml` and one mesh per link under `folder/<name>`."""
    target = folder / design.name
    target.mkdir(parents=True, exist_ok=True)
    shapes: Mapping[str, Shape] = design.look(design)
    texts = {f"{design.name}.urdf": urdf_text(design, shapes), f"{design.name}.toml": toml_text(design)}
    texts |= {f"{link}.gltf": gltf(shape) for link, shape in shapes.items()}
    for old in target.glob("*.gltf"):
        if old.name not in texts:
            old.unlink()
    for name, text in texts.items():
        (target / name).write_bytes(text.encode())
    return [target / name for name in texts]


def link_masses(design: Design) -> list[tuple[float, Array, Array]]:
    """Mass, centre of mass and inertia of links 1..n in their URDF frames."""
    frames = design.link_frames()
    masses = design.masses
    if masses.table is None:
        upright = pose(design.rotation, (0, 0, masses.start)) if masses.start is not None else np.eye(4)
        moved, stated = frames, [upright] * len(frames)
    else:
        at = np.radians(masses.at if masses.at is not None else np.zeros(len(frames)))
        moved = [motion @ X for motion, X in zip(design.chain.motions(at), frames, strict=True)]
        stated = masses.table.frames()[1:]
    result = []
    for X_BL, X_BS, mass in zip(moved, stated, masses.links, strict=True):
        X_LS = np.linalg.inv(X_BL) @ X_BS
        R = X_LS[:3, :3]
        com = R @ np.array(mass.com) / 1000 + X_LS[:3, 3]
        result.append((mass.mass, com, R @ mass.tensor() @ R.T))
    return result


def urdf_text(design: Design, shapes: Mapping[str, Shape]) -> str:
    base = _base_inertia(design.base_mass)
    lines = ['<?xml version="1.0"?>', f"<!-- {design.title}. {HEADER} -->", f'<robot name="{design.name}">']
    lines += _link("base_link", base, shapes)
    for i, mass in enumerate(link_masses(design)):
        lines += _link(f"link_{i + 1}", mass, shapes)
    lines += _link("flange", None, shapes)
    frames = design.link_frames()
    parent = np.eye(4)
    for i, (X, axis, limits) in enumerate(zip(frames, design.chain.axes, design.limits, strict=True)):
        X_PL = np.linalg.inv(parent) @ X
        rpy = np.radians(design.mount) if i == 0 else np.zeros(3)
        unit = math.pi / 180 if axis.kind == "revolute" else 1e-3
        lines += [
            f'  <joint name="{design.joint_names[i]}" type="{axis.kind}">',
            f'    <origin xyz="{_vector(X_PL[:3, 3])}" rpy="{" ".join(_exact(v) for v in rpy)}"/>',
            f'    <parent link="{f"link_{i}" if i else "base_link"}"/>',
            f'    <child link="link_{i + 1}"/>',
            f'    <axis xyz="{_vector(X[:3, :3].T @ axis.direction)}"/>',
            f'    <limit lower="{_exact(limits.lower * unit)}" upper="{_exact(limits.upper * unit)}"'
            f' effort="{_number(limits.effort)}" velocity="{_exact(round(limits.velocity * unit, 6))}"/>',
            "  </joint>",
        ]
        parent = X
    X_LF = np.linalg.inv(parent) @ design.chain.flange
    turned = " ".join(_exact(v) for v in _right_angles(X_LF))
    lines += [
        '  <joint name="flange_joint" type="fixed">',
        f'    <origin xyz="{_vector(X_LF[:3, 3])}" rpy="{turned}"/>',
        f'    <parent link="link_{len(frames)}"/>',
        '    <child link="flange"/>',
        "  </joint>",
        "</robot>",
    ]
    return "\n".join(lines) + "\n"


def toml_text(design: Design) -> str:
    lines = [f"# {HEADER}", "schema = 1"]
    fields = {
        "name": design.name,
        "title": design.title,
        "urdf": f"{design.name}.urdf",
        "flange": "flange",
        "gravity": [0.0, 0.0, -STANDARD_GRAVITY],
    }
    if design.pose_repeatability is not None:
        fields["pose_repeatability_mm"] = design.pose_repeatability
    lines += _table(fields)
    for i, name in enumerate(design.joint_names):
        data = {key: values[i] for key, values in design.joint_data.items()}
        lines += ["", "[[joints]]", *_table({"name": name, **data})]
    if design.compensator is not None:
        lines += ["", "[compensator]", *_table(design.compensator)]
    for name, stiffness in design.bending_stiffness.items():
        lines += ["", "[[links]]", *_table({"name": name, "bending_stiffness": stiffness})]
    if design.controller is not None:
        lines += ["", "[controller]", *_table(design.controller)]
    lines += ["", "[controller.loop]", *_table({**LOOP, **design.loop})]
    loop = "assumed: cycle times, delay, bandwidth and friction (share of the stretched arm's weight)"
    lines += ["", "[source]", *_table({**design.source, "loop": loop})]
    return "\n".join(lines) + "\n"


def _base_inertia(mass: Mass) -> tuple[float, Array, Array]:
    return mass.mass, np.array(mass.com) / 1000, mass.tensor()


def _link(name: str, mass: tuple[float, Array, Array] | None, shapes: Mapping[str, Shape]) -> Iterable[str]:
    lines = []
    if mass is not None:
        m, com, tensor = mass
        keys = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
        inertia = " ".join(f'{key}="{_number(tensor[ij])}"' for key, ij in keys.items())
        lines += [
            "    <inertial>",
            f'      <origin xyz="{_vector(com)}" rpy="0 0 0"/>',
            f'      <mass value="{_number(m)}"/>',
            f"      <inertia {inertia}/>",
            "    </inertial>",
        ]
    if name in shapes:
        mesh = f'<mesh filename="{name}.gltf"/>'
        lines += [f"    <visual><geometry>{mesh}</geometry></visual>"]
    if not lines:
        return [f'  <link name="{name}"/>']
    return [f'  <link name="{name}">', *lines, "  </link>"]


def _right_angles(X: Array) -> Array:
    """Roll, pitch, yaw of a rotation by right angles, exact: multiples of pi / 2."""
    quarter = math.pi / 2
    for yaw in (0, 1, 2, -1):
        for pitch in (0, 1, -1):
            for roll in (0, 1, 2, -1):
                R = rotation_z(90 * yaw) @ rotation_y(90 * pitch) @ rotation_x(90 * roll)
                if np.allclose(R, X[:3, :3], atol=1e-9):
                    return np.array([roll, pitch, yaw]) * quarter
    raise ValueError("the flange is not turned by right angles to the last link")


def _vector(values: Array) -> str:
    return " ".join(_number(v) for v in values)


def _number(value: float) -> str:
    """Twelve decimals: below any tolerance here, above the last bits that machines disagree on."""
    return f"{round(float(value), 12) + 0.0:.10g}"


def _exact(value: float) -> str:
    return repr(float(value) + 0.0).removesuffix(".0")


def _table(fields: Mapping[str, Any]) -> list[str]:
    width = max(len(key) for key in fields)
    return [f"{key:<{width}} = {_value(value)}" for key, value in fields.items()]


def _value(value: Any) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_value(v)}" for key, v in value.items()) + " }"
    return repr(value) if isinstance(value, int) else repr(float(value))
