"""path.csv: the workbench's own table of a path, also for controllers that no other format serves.

Columns as the path section of the file formats says: `t_s` and either joints (`q1_deg`, `_rad`, `_mm`,
`_m`) or tool poses (`x_mm y_mm z_mm` with `qw qx qy qz`, or `a_deg b_deg c_deg` = KUKA A B C), in the
base frame; `dwell_s` where the robot is to stand. Written are quaternions, free of gimbal lock.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping
from contextlib import suppress

import numpy as np

from ...files.faults import Fault, InputError
from ...robot import rotations
from .base import Array, Program
from .format import Format

MM, DEG, QUATERNION, SECOND = 6, 8, 12, 6  # decimals
POSITION, TURN, ANGLES = ("x_mm", "y_mm", "z_mm"), ("qw", "qx", "qy", "qz"), ("a_deg", "b_deg", "c_deg")
JOINT_UNITS = {"deg": np.pi / 180, "rad": 1.0, "mm": 1e-3, "m": 1.0}


class Csv(Format):
    name, title, extension, newline = "csv", "CSV", ".csv", "\n"
    mm_digits, deg_digits = MM, DEG
    arm_joints = None
    most_rails = None
    carries_tool = False

    def rounding(self) -> tuple[float, float]:
        return super().rounding()[0], 4 * 0.5 * 10.0**-QUATERNION

    def _check_name(self, program: Program) -> list[Fault]:
        """A table has no name inside; the file may be named at will."""
        bad = re.search(r'[/\\:*?"<>|]', program.name)
        what, mend = "has a character that files cannot have", f"say {self.legal_name(program.name)!r}"
        return [Fault(f"program name {program.name!r}", what, mend)] if bad else []

    def legal_name(self, text: str) -> str:
        return re.sub(r'[/\\:*?"<>|]+', "_", text) or "path"

    def write(self, program: Program) -> dict[str, str]:
        time = program.time
        if time is None:  # then a second a point, and its dwell
            time = np.concatenate([[0.0], np.cumsum(1.0 + program.dwell[:-1])])
        columns = {"t_s": [f"{value:z.{SECOND}f}" for value in time]}
        columns |= self._joints(program) if program.kind == "joints" else self._poses(program)
        if program.dwell.any():
            columns["dwell_s"] = [f"{value:z.{SECOND}f}" for value in program.dwell]
        rows = [",".join(row) for row in zip(*columns.values(), strict=True)]
        return {f"{program.name or 'path'}{self.extension}": "\n".join([",".join(columns), *rows, ""])}

    def _joints(self, program: Program) -> dict[str, list[str]]:
        assert program.q is not None
        columns = {}
        for i, sliding in enumerate(program.sliding):
            scale, unit, digits = (1e3, "mm", MM) if sliding else (180 / np.pi, "deg", DEG)
            columns[f"q{i + 1}_{unit}"] = [f"{scale * value:z.{digits}f}" for value in program.q[:, i]]
        return columns

    def _poses(self, program: Program) -> dict[str, list[str]]:
        assert program.X is not None
        place = {n: [f"{1e3 * v:z.{MM}f}" for v in program.X[:, i, 3]] for i, n in enumerate(POSITION)}
        quaternion = rotations.quaternions(program.X[:, :3, :3])
        return place | {n: [f"{v:z.{QUATERNION}f}" for v in quaternion[:, i]] for i, n in enumerate(TURN)}

    def read(self, files: Mapping[str, str]) -> Program:
        place, text = next(iter(files.items()))
        columns, faults = _columns(place, text)
        joints = sorted(
            (n for n in columns if re.fullmatch(r"q\d+_\w+", n)), key=lambda n: int(n[1 : n.index("_")])
        )
        poses = set(POSITION) <= columns.keys() and (
            set(TURN) <= columns.keys() or set(ANGLES) <= columns.keys()
        )
        if "t_s" not in columns:
            faults.append(Fault(place, "has no column t_s", "give the time of each point in seconds"))
        if bool(joints) == poses:
            what = "both joints and tool poses" if poses else "neither joints nor whole tool poses"
            faults.append(Fault(place, f"has {what}", f"give q1_deg ... or {' '.join(POSITION + TURN)}"))
        faults += [Fault(place, f"column {n!r} has no known unit", f"one of {', '.join(JOINT_UNITS)}")
                   for n in joints if n.split("_", 1)[1] not in JOINT_UNITS]  # fmt: skip
        if faults:
            raise InputError(faults)
        name, dwell = re.sub(r"\.\w+$", "", place), columns.get("dwell_s", np.zeros(1))
        if joints:
            units = [n.split("_", 1)[1] for n in joints]
            q = np.stack(
                [columns[n] * JOINT_UNITS[unit] for n, unit in zip(joints, units, strict=True)], axis=1
            )
            sliding = tuple(unit in ("mm", "m") for unit in units)
            return Program(name, q=q, time=columns["t_s"], dwell=dwell, kind="joints", sliding=sliding)
        return Program(name, _poses(place, columns), time=columns["t_s"], dwell=dwell)


def _columns(place: str, text: str) -> tuple[dict[str, Array], list[Fault]]:
    """The table's columns as numbers, and a fault for every cell that is none."""
    faults: list[Fault] = []
    rows = [(number, row) for number, row in enumerate(csv.reader(io.StringIO(text)), 1) if any(row)]
    if len(rows) < 2:
        return {}, [Fault(place, "has no points", "a header and at least one row")]
    names = [name.strip() for name in rows[0][1]]
    if len(names) == 1 and (other := re.search(r"[;\t]", names[0])):
        return {}, [
            Fault(f"{place} line {rows[0][0]}", f"columns are separated by {other[0]!r}", "use commas")
        ]
    if len(set(names)) < len(names):
        return {}, [Fault(f"{place} line {rows[0][0]}", "names a column twice")]
    values = np.full((len(rows) - 1, len(names)), np.nan)
    for i, (number, row) in enumerate(rows[1:]):
        if len(row) != len(names):
            faults.append(Fault(f"{place} line {number}", f"has {len(row)} cells, the header {len(names)}"))
            continue
        for k, cell in enumerate(row):
            with suppress(ValueError):
                values[i, k] = float(cell)
            if not np.isfinite(values[i, k]):
                faults.append(
                    Fault(f"{place} line {number}", f"{names[k]} is {cell.strip()!r}, not a number")
                )
    if "t_s" in names:
        late = np.flatnonzero(np.diff(values[:, names.index("t_s")]) < 0) + 1
        faults += [Fault(f"{place} line {rows[i + 1][0]}", "time runs back", "order by t_s") for i in late]
    return {name: values[:, k] for k, name in enumerate(names)}, faults


def _poses(place: str, columns: Mapping[str, Array]) -> Array:
    position = 1e-3 * np.stack([columns[name] for name in POSITION], axis=1)
    if not set(TURN) <= columns.keys():
        return rotations.pose(
            position, rotations.from_zyx(np.radians(np.stack([columns[n] for n in ANGLES], axis=1)))
        )
    quaternion = np.stack([columns[name] for name in TURN], axis=1)
    bad = np.flatnonzero(np.abs(np.linalg.norm(quaternion, axis=1) - 1) > 0.01)
    if len(bad):
        raise InputError(
            [Fault(f"{place} row {i + 1}", "quaternion has not length 1", "normalise it") for i in bad]
        )
    return rotations.pose(position, rotations.from_quaternions(quaternion))


FORMAT = Csv()
