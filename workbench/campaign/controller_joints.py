"""Joint columns as a robot's controller gives them (`[poses] joints = "controller"`), made the URDF's."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..files.faults import Fault, InputError, read_text
from ..files.table_columns import Layout
from ..files.table_rows import content, split
from ..files.tables import Table
from ..robot.convention import Convention
from ..robot.description import Joint, Robot
from ..robot.kinematics import Array

NEGLIGIBLE = 1e-12  # of a matrix whose entries are ones and gear couplings


def stated(robot: Robot, place: str) -> Convention:
    """The robot's convention; `InputError` where its TOML does not say one. place: what asks for it."""
    convention = robot.convention
    if convention is None:
        what = f"{robot.path or robot.name} does not say how its controller counts the joints"
        raise InputError(Fault(place, what, "add [controller] there, or take the line out"))
    return convention


def joints_in_order(robot: Robot, convention: Convention) -> list[Joint]:
    """The robot's joints as the controller's columns have them."""
    return [robot.joints[j] for j in convention.order]


def by_the_controllers_names(path: Path, layout: Layout, convention: Convention) -> Layout:
    """The layout, with the columns that are named as the controller names its joints: A1 is q1, and so on; in
    the file's header, or on the left under `columns` and `units`."""
    ours = {
        name: f"q{k}_{unit}"
        for k, (name, unit) in enumerate(zip(convention.names, convention.units, strict=True), 1)
    }
    columns, units = (
        {key if ours.get(key) in said else ours.get(key, key): value for key, value in said.items()}
        for said in (layout.columns, layout.units)
    )
    layout = layout.model_copy(update={"columns": columns, "units": units})
    rows, _, _ = split(content(read_text(path, layout.encoding), layout), layout.separator, str(path))
    header = [cell.strip() for cell in rows[0]] if layout.header and rows else []
    said = {name.split("_")[0] for name in layout.columns}
    named = {our: name for name, our in ours.items() if name in header and our.split("_")[0] not in said}
    return layout.model_copy(update={"columns": {**layout.columns, **named}})


def to_urdf(table: Table, convention: Convention) -> None:
    """Positions, read-back positions, torques and sides of motion of a table of poses, in place."""
    back = np.asarray(np.linalg.inv(convention.A), dtype=np.float64)
    back[np.abs(back) < NEGLIGIBLE] = 0.0
    n = len(convention.names)
    for stem in ("q", "r", "tau", "dir"):
        keys = [f"{stem}{k}" for k in range(1, n + 1)]
        if not any(key in table.numbers for key in keys):
            continue
        lacking = np.full(len(table), 0.0 if stem == "dir" else np.nan)
        shown = np.stack([table.numbers.get(key, lacking) for key in keys], axis=1)
        if stem in ("q", "r"):
            values = _product(shown - convention.zero, back)
        elif stem == "tau":
            values = _product(shown, convention.A.T)
        else:
            values = convention.sides(shown)
        labels, units = dict(table.labels), dict(table.units)
        for key, j in zip(keys, convention.order, strict=True):
            table.numbers[f"{stem}{j + 1}"] = values[:, j]
            if key in labels:
                table.labels[f"{stem}{j + 1}"] = labels[key]
                table.units[f"{stem}{j + 1}"] = units[key]


def _product(values: Array, matrix: Array) -> Array:
    """(rows, n) values times the matrix, where an empty cell spoils only what depends on it."""
    columns = []
    for row in matrix:
        used = np.flatnonzero(row)
        columns.append(values[:, used] @ row[used])
    return np.stack(columns, axis=1)
