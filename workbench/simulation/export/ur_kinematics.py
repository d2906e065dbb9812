"""The kinematics file of Universal Robots' ROS description: where each joint begins in the link before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...files.faults import Fault, InputError
from ...robot.kinematics import Array
from ...robot.rotations import screw
from .content import Content
from .dh import Table, table_of
from .text import commented, number
from .urdf import Files, rpy

LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
TWISTS = np.radians([90.0, 0.0, 0.0, 90.0, -90.0, 0.0])
NEAR = 0.02  # rad, m: how far a calibrated arm may be from the family's pattern


def write(content: Content, header: list[str]) -> Files:
    """NAME_kinematics.yaml."""
    lines = ["kinematics:"]
    for link, X in zip(LINKS, origins(content), strict=True):
        lines.append(f"  {link}:")
        values = [*X[:3, 3], *rpy(X[:3, :3])]
        keys = ("x", "y", "z", "roll", "pitch", "yaw")
        lines += [f"    {key}: {_real(value)}" for key, value in zip(keys, values, strict=True)]
    lines.append(f"  hash: {content.robot.name}_workbench")
    return {f"{content.robot.name}_kinematics.yaml": commented(header) + "\n".join(lines) + "\n"}


def origins(content: Content) -> Array:
    """(6, 4, 4) of each joint in the link before it, the first in UR's own base, where the arm at zero points
    along −x. Raises `InputError` for an arm of another family."""
    table = _makers_table(content)
    before, out = _half_turn(table) @ table.base, []
    for theta, d, a, alpha, beta in table.rows:
        out.append(before @ screw("z", theta, d))
        before = screw("x", alpha, a) @ screw("y", beta, 0.0)
    # behind the last axis only a turn about it is left: it belongs to the last joint's zero
    out[-1] = out[-1] @ before @ table.tool
    return np.array(out)


def has_flange(_: Content) -> bool:
    """It ends with the last joint."""
    return False


def notes(content: Content) -> list[str]:
    """Where the file's base stands, if not where the robot's does."""
    if (_half_turn(_makers_table(content)) == np.eye(4)).all():
        return []
    base = content.robot.base
    return [f"the shoulder counts from UR's own base (base_link_inertia), half a turn about z from {base}"]


def _makers_table(content: Content) -> Table:
    """The arm's table with the common normals the maker's way: a row's x may point both ways. Raises
    `InputError` for an arm of another family."""
    table = table_of(content.arm)
    if len(table.rows) == 6 and not table.prismatic.any():
        rows = table.rows.copy()
        for i, twist in enumerate(TWISTS[:-1]):
            if (rows[i, 3] * twist if twist else -rows[i, 2]) < 0:
                rows[i, 2:] *= -1
                rows[i : i + 2, 0] += np.pi
        rows[:, 0] = np.remainder(rows[:, 0] + np.pi, 2 * np.pi) - np.pi
        table = replace(table, rows=rows)
        if _is_ur(table):
            return table
    what = "is no arm of Universal Robots' kind (axes 2, 3, 4 parallel, three crossing pairs)"
    raise InputError(Fault(f"{content.robot.name}: --to ur-kinematics", what, "use urdf or dh"))


def _half_turn(table: Table) -> Array:
    """(4, 4) from the robot's base to UR's own: many URDFs have their base_link turned half about z."""
    return screw("z", np.pi * round(abs(table.rows[0, 0]) / np.pi), 0.0)


def _is_ur(table: Table) -> bool:
    rows = table.rows
    short = rows[[0, 3, 4, 5], 2]
    behind = screw("x", rows[5, 3], rows[5, 2]) @ screw("y", rows[5, 4], 0.0) @ table.tool
    along = np.abs(behind[:3, 2] - [0, 0, 1]).max() < 1e-9 and np.abs(behind[:2, 3]).max() < 1e-9
    return bool(along and np.abs(rows[:, 3] - TWISTS).max() < NEAR and np.abs(short).max() < NEAR)


def _real(value: float) -> str:
    """YAML 1.1 reads 1e-05 as a text: a mantissa with a point."""
    text = number(round(value, 13))
    mantissa, e, power = text.partition("e")
    return f"{mantissa if '.' in mantissa else mantissa + '.0'}{e}{power}"
