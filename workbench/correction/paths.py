"""Paths: joints or tool poses over time, read from and written to CSV."""

from __future__ import annotations

import pathlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..campaign.file import WRENCH_COLUMNS
from ..files.faults import InputError
from ..files.tables import Column, Layout, Table, column_cells, parse_table, read_table, table_text
from ..files.whole import put
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.rotations import from_quaternions, from_zyx, pose, quaternions, zyx_angles
from .path_table import (
    ABC,
    DWELL,
    POSITION,
    QUATERNION,
    TEMPERATURE,
    TIME,
    check_samples,
    names,
    path_columns,
    stacked,
)

ROWS = 10_000  # of a table whose cells are made at a time
PATH_DIGITS = 14  # significant ones: below 1e-12 rad on any joint, and numbers as typed come back as typed


@dataclass(frozen=True, eq=False)
class Path:
    """A path of N samples, as joints or as tool poses.

    time: (N,) s, rising; q: (N, n) rad or m; X: (N, 4, 4) tool in the base frame. One of q and X
    is None. wrench: (N, 6) [N, N·m] on the robot at the flange origin, base frame, and temperature:
    (N,) [degC], where the file gives them. file and lines (N): where the samples stand, for messages.
    dwell: (N,) standstill after arrival [s], for programs; sliding: (n,) which joints slide, where known;
    files: (N) each sample's own, of programs that stand in several.
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
    dwell: Array | None = None
    sliding: tuple[bool, ...] = ()
    files: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        kind = "joints" if self.q is not None else "tool poses"
        return f"Path {self.title!r}: {len(self)} samples of {kind}, {np.ptp(self.time):g} s"

    def place(self, index: int) -> str:
        """Where a sample stands: file and line."""
        line = self.lines[index] if self.lines else index + 2
        file = self.files[index] if self.files else self.file or (self.title or "path") + ".csv"
        return f"{file} line {line}"


def load_path(file: str | pathlib.Path, robot: Robot | None = None) -> Path:
    r"""Load and check a path.

    file: a table with `t_s` and either joints (`q1_deg` ..., `q2_mm` for a sliding one) or tool poses in the
    base frame (`x_mm y_mm z_mm` with `qw qx qy qz` or `a_deg b_deg c_deg`). With a robot, the joint columns
    have to be the robot's, each in a unit that fits. The columns `fx_N fy_N fz_N mx_Nm my_Nm mz_Nm`,
    `temp_degC` and `dwell_s` may stand beside. Raises `InputError` with all faults.

    >>> import pathlib
    >>> from workbench import load_path, load_robot
    >>> table = "t_s,q1_deg,q2_mm,q3_mm", "0,30,200,200", "0.5,32,200,210", "1,34,200,220"
    >>> _ = pathlib.Path("path.csv").write_text("\n".join(table))
    >>> path = load_path("path.csv", load_robot("cylindrical"))
    >>> path.q.shape, path.q[-1].round(4).tolist()  # rad, m
    ((3, 3), [0.5934, 0.2, 0.22])
    """
    return _checked(read_table(pathlib.Path(file), Layout(), path_columns(robot)), robot, fewest=2)


def parse_path(text: str, file: str) -> Path:
    """The path in a text, by the same rules; one sample is enough. `file` is what its faults call it."""
    return _checked(parse_table(text, pathlib.Path(file), Layout(), path_columns(None)), None, fewest=1)


def _checked(table: Table, robot: Robot | None, fewest: int) -> Path:
    """The path of a table of `fewest` samples at least."""
    if not len(table):
        raise InputError(table.faults)
    joints = check_samples(table, robot, fewest)
    if table.faults:
        raise InputError(table.faults)
    notes = [f"{table.path}: column {name!r} is not used" for name in table.unused]
    if "dwell" in table.numbers:
        notes.append(f"{table.path}: dwell_s counts in written programs; nothing else stands still for it")
    return Path(
        table.numbers["t"],
        stacked(table, joints) if joints else None,
        None if joints else _tool_poses(table),
        table.path.stem,
        tuple(notes),
        _wrench(table),
        table.numbers.get("temp"),
        str(table.path),
        tuple(int(line) for line in table.lines),
        table.numbers.get("dwell"),
        tuple(table.units[name].dimension == "length" for name in joints),
    )


def _tool_poses(table: Table) -> Array:
    """(N, 4, 4)."""
    if "qw" in table.numbers:
        turned = from_quaternions(stacked(table, names(*QUATERNION)))
    else:
        turned = from_zyx(stacked(table, names(*ABC)))
    return pose(stacked(table, names(*POSITION)), turned)


def _wrench(table: Table) -> Array | None:
    """(N, 6), what is not given zero; None where nothing is given."""
    if not any(name in table.numbers for name in names(*WRENCH_COLUMNS)):
        return None
    nothing = np.zeros(len(table))
    return np.stack([table.numbers.get(name, nothing) for name in names(*WRENCH_COLUMNS)], axis=1)


def write_path(
    file: str | pathlib.Path,
    path: Path,
    robot: Robot | None = None,
    orientation: Literal["quaternion", "abc"] = "quaternion",
) -> None:
    """Write a path as CSV, whole or not at all; `load_path` reads it back, digit by digit.

    Joints stand in degrees, in mm where the robot's (or the path's own) joints slide; tool poses in mm with
    quaternions, or with KUKA's angles (`orientation` "abc").
    """
    put(pathlib.Path(file), path_text(path, robot, orientation))


def path_text(
    path: Path, robot: Robot | None = None, orientation: Literal["quaternion", "abc"] = "quaternion"
) -> str:
    """The text of `path.csv`. Joints stand in degrees, in mm where they slide: the robot's own, else the
    path's (where neither says, all turn)."""
    columns: list[tuple[Column, Array]] = [(TIME, path.time)]
    if path.q is not None:
        sliding = robot.sliding if robot else path.sliding
        for index, slides in enumerate(sliding or (False,) * path.q.shape[1]):
            dimension = "length" if slides else "angle"
            columns.append((Column(f"q{index + 1}", (dimension,)), path.q[:, index]))
    if path.X is not None:
        R = path.X[:, :3, :3]
        columns += zip(POSITION, path.X[:, :3, 3].T, strict=True)
        if orientation == "abc":
            columns += zip(ABC, zyx_angles(R).T, strict=True)
        else:
            columns += zip(QUATERNION, quaternions(R).T, strict=True)
    if path.wrench is not None:
        columns += zip(WRENCH_COLUMNS, path.wrench.T, strict=True)
    columns += [(TEMPERATURE, path.temperature)] if path.temperature is not None else []
    columns += [(DWELL, path.dwell)] if path.dwell is not None else []
    header = [column_cells(column, values[:0])[0] for column, values in columns]
    return table_text(header, _rows(columns))


def _rows(columns: Sequence[tuple[Column, Array]]) -> Iterator[tuple[str, ...]]:
    """The cells row by row, made some thousand rows at a time: as texts they take far more room."""
    for start in range(0, len(columns[0][1]), ROWS):
        some = slice(start, start + ROWS)
        cells = [column_cells(column, values[some], PATH_DIGITS)[1] for column, values in columns]
        yield from zip(*cells, strict=True)
