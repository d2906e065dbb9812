"""Paths: joints or tool poses over time, read from and written to CSV (contract, section 3)."""

from __future__ import annotations

import pathlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..files.faults import Fault, InputError
from ..files.tables import Column, Layout, Table, number_text, read_table, write_table
from ..robot.description import Robot
from ..robot.rotations import from_quaternions, from_zyx, pose, quaternions, zyx_angles

Array = NDArray[np.float64]
MOST_JOINTS = 20  # looked for where no robot says how many
POSITION = ("x", "y", "z")
QUATERNION = ("qw", "qx", "qy", "qz")
ABC = ("a", "b", "c")
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")


@dataclass(frozen=True, eq=False)
class Path:
    """A path of N samples, as joints or as tool poses.

    time: (N,) s, rising; q: (N, n) rad or m; X: (N, 4, 4) tool in the base frame. One of q and X
    is None. wrench: (N, 6) [N, N·m] on the robot at the flange origin, base frame, and temperature:
    (N,) [degC], where the file gives them. file and lines (N): where the samples stand, for messages.
    """

    time: Array
    q: Array | None = None
    X: Array | None = None
    title: str = ""
    warnings: tuple[str, ...] = ()
    wrench: Array | None = None
    temperature: Array | None = None
    file: str = ""
    lines: tuple[int, ...] = ()

    def __len__(self) -> int:
        return len(self.time)

    def place(self, index: int) -> str:
        """Where a sample stands: file and line."""
        line = self.lines[index] if self.lines else index + 2
        file = self.file or (self.title or "path") + ".csv"
        return f"{file} line {line}"


def load_path(file: str | pathlib.Path, robot: Robot | None = None) -> Path:
    """Load and check a path. Raises `InputError` with all faults.

    With a robot, the joint columns have to be the robot's, each in a unit that fits. The columns
    `fx_N fy_N fz_N mx_Nm my_Nm mz_Nm` and `temp_degC` may stand beside, as in `poses.csv`.
    """
    file = pathlib.Path(file)
    table = read_table(file, Layout(), _columns(robot))
    if not len(table):
        raise InputError(table.faults)
    _check_time(table)
    joints = _joint_names(table, robot)
    poses = [name for name in (*POSITION, *QUATERNION, *ABC) if name in table.numbers]
    if joints and poses:
        one, other = (
            next(table.labels[name] for name in names if name in table.labels) for names in (joints, poses)
        )
        what = f"has joints ({one}, ...) and tool poses ({other}, ...)"
        table.faults.append(Fault(str(file), what, "a path is one or the other: take one out"))
    elif not joints and not poses:
        mend = "give q1_deg ... , or x_mm y_mm z_mm with qw qx qy qz or with a_deg b_deg c_deg"
        table.faults.append(Fault(str(file), "has neither joints nor tool poses", mend))
    elif poses:
        _check_poses(table)
    if table.faults:
        raise InputError(table.faults)
    q = np.stack([table.numbers[name] for name in joints], axis=1) if joints else None
    warnings = tuple(f"{file}: column {name!r} is not used" for name in table.unused)
    return Path(
        table.numbers["t"],
        q,
        None if joints else _tool_poses(table),
        file.stem,
        warnings,
        _wrench(table),
        table.numbers.get("temp"),
        str(file),
        tuple(int(line) for line in table.lines),
    )


def _columns(robot: Robot | None) -> list[Column]:
    columns = [Column("t", ("time",), required=True, mend="every sample needs its time")]
    columns += [Column(name, ("length",)) for name in POSITION]
    columns += [Column(name) for name in QUATERNION] + [Column(name, ("angle",)) for name in ABC]
    columns += [Column(name, ("force" if name[0] == "f" else "torque",)) for name in WRENCH]
    columns += [Column("temp", ("temperature",))]
    if robot is None:
        return columns + [Column(f"q{index}", ("angle", "length")) for index in range(1, MOST_JOINTS + 1)]
    for index, joint in enumerate(robot.joints, 1):
        slides = joint.kind == "prismatic"
        subject = f"{joint.name} {'slides' if slides else 'turns'}"
        columns.append(Column(f"q{index}", ("length" if slides else "angle",), subject=subject))
    return columns


def _joint_names(table: Table, robot: Robot | None) -> list[str]:
    """The joint columns; faults where one between is missing or the robot has more."""
    given = [name for name in table.numbers if name[0] == "q" and name[1:].isdigit()]
    if not given:
        return []
    count = max(int(name[1:]) for name in given) if robot is None else len(robot.joints)
    names = [f"q{index}" for index in range(1, count + 1)]
    absent = [name for name in names if name not in given]
    if absent:
        table.faults.append(
            Fault(str(table.path), f"no column {', '.join(absent)}", "a path needs all joints")
        )
    for name in table.unused:
        if robot is not None and re.match(r"q\d+(_|$)", name):
            what = f"column {name!r}, but {robot.name} has {count} joints"
            table.faults.append(Fault(str(table.path), what, "take it out, or name the right robot"))
    return names


def _check_time(table: Table) -> None:
    """Time rises; of a run that lies behind, every line is told."""
    time = table.numbers.get("t")
    if time is None:
        return
    reached = np.fmax.accumulate(time)
    back = np.flatnonzero(time[1:] <= reached[:-1]) + 1
    whats = [
        f"{table.labels['t']} is {number_text(now)} s, after {number_text(before)} s"
        for now, before in zip(time[back], reached[back - 1], strict=True)
    ]
    table.add_faults(back.tolist(), whats, ["time has to rise from line to line"] * len(back))
    if len(time) < 2:
        table.faults.append(Fault(str(table.path), "has one sample only", "a path needs two at least"))


def _check_poses(table: Table) -> None:
    def need(names: Sequence[str], units: str) -> None:
        absent = [name for name in names if name not in table.numbers]
        if absent:
            what = f"no column {', '.join(name + units for name in absent)}"
            table.faults.append(Fault(str(table.path), what, "a tool pose needs place and orientation"))

    need(POSITION, "_mm")
    quaternion = any(name in table.numbers for name in QUATERNION)
    if quaternion and any(name in table.numbers for name in ABC):
        mend = "keep qw qx qy qz or a_deg b_deg c_deg"
        table.faults.append(Fault(str(table.path), "gives the orientation twice", mend))
    elif not quaternion and not any(name in table.numbers for name in ABC):
        mend = "give qw qx qy qz, or a_deg b_deg c_deg (KUKA: R = Rz(a) Ry(b) Rx(c))"
        table.faults.append(Fault(str(table.path), "has no orientation", mend))
    elif not quaternion:
        need(ABC, "_deg")
    else:
        need(QUATERNION, "")
        if all(name in table.numbers for name in QUATERNION):
            length = np.sqrt(sum(table.numbers[name] ** 2 for name in QUATERNION))
            off = np.flatnonzero(np.abs(length - 1.0) > 1e-3)
            whats = [f"qw qx qy qz has length {length[row]:.4g}, not 1" for row in off]
            table.add_faults(off.tolist(), whats, ["is one of the four wrong, or their order?"] * len(off))


def _tool_poses(table: Table) -> Array:
    """(N, 4, 4)."""

    def columns(names: Sequence[str]) -> Array:
        return np.stack([table.numbers[name] for name in names], axis=1)

    turned = from_quaternions(columns(QUATERNION)) if "qw" in table.numbers else from_zyx(columns(ABC))
    return pose(columns(POSITION), turned)


def _wrench(table: Table) -> Array | None:
    """(N, 6), what is not given zero; None where nothing is given."""
    if not any(name in table.numbers for name in WRENCH):
        return None
    nothing = np.zeros(len(table))
    return np.stack([table.numbers.get(name, nothing) for name in WRENCH], axis=1)


def write_path(
    file: str | pathlib.Path,
    path: Path,
    robot: Robot | None = None,
    orientation: Literal["quaternion", "abc"] = "quaternion",
) -> None:
    """Write a path as CSV, whole or not at all; `load_path` reads it back.

    Joints go out in degrees, in mm where `robot` has a sliding joint (without a robot all turn).
    """
    columns = [("t_s", path.time)]
    if path.q is not None:
        slides = [joint.kind == "prismatic" for joint in robot.joints] if robot else [False] * path.q.shape[1]
        for index, sliding in enumerate(slides):
            unit, factor = ("mm", 1e3) if sliding else ("deg", 180.0 / np.pi)
            columns.append((f"q{index + 1}_{unit}", path.q[:, index] * factor))
    if path.X is not None:
        R = path.X[:, :3, :3]
        columns += zip(("x_mm", "y_mm", "z_mm"), 1e3 * path.X[:, :3, 3].T, strict=True)
        if orientation == "abc":
            columns += zip(("a_deg", "b_deg", "c_deg"), np.rad2deg(zyx_angles(R)).T, strict=True)
        else:
            columns += zip(QUATERNION, quaternions(R).T, strict=True)
    if path.wrench is not None:
        columns += zip((f"{n}_N" if n[0] == "f" else f"{n}_Nm" for n in WRENCH), path.wrench.T, strict=True)
    if path.temperature is not None:
        columns.append(("temp_degC", path.temperature))
    rows = [
        [number_text(value) for value in row] for row in zip(*(column for _, column in columns), strict=True)
    ]
    write_table(pathlib.Path(file), [name for name, _ in columns], rows)
