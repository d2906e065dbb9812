"""The table of points: a row per point or targets side by side; and poses that nobody names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..files.faults import Fault, InputError, read_text
from ..files.tables import Column, Layout, Table, parse_table, read_table
from .assemble import ONLY, some
from .file import ANGLES, QUATERNION, TIME, UNSEEN, CampaignFile, Turns, point_columns
from .turns import rotations

ROUNDED = 0.01  # that a quaternion's length is off 1 by its decimals at most
XYZ = ("x", "y", "z")
AXES = ("x_mm", "y_mm", "z_mm")
WITHOUT_TURNS = "a 6-D measurement is not read beside single reflectors"
NO_TURNS = "take turned_mm out: all are read as points then, without turns; or leave out the reflectors"


def read_points(path: Path, file: CampaignFile, place: str, named: bool = False) -> Table:
    """The points as the campaign's file says; faults are in the table. named: they have to have `pose_id`."""
    layout = file.points
    if not layout.wide:
        table = seen_rows(read_table(path, layout, point_columns(file, named), place))
        return table if layout.turned_mm is None else _three_each(table, file, 1e-3 * layout.turned_mm)
    columns = [
        Column("pose_id", text=True, required=named),
        *(Column(axis, ("length",), required=True, blank=True, wild=True) for axis in "xyz"),
        TIME,
    ]
    try:
        text = read_text(path, layout.encoding)
    except InputError as error:
        return Table(path, faults=list(error.faults))
    parts = []
    for target, places in layout.wide.items():
        mapping = {**layout.columns, **dict(zip(AXES, places, strict=True))}
        own = Layout(**{key: getattr(layout, key) for key in Layout.model_fields} | {"columns": mapping})
        part = parse_table(text, path, own, columns, f"{place}.wide.{target}")
        part.texts["target"] = [target] * len(part)
        parts.append(seen_rows(part, f"of {target} "))
    return _stacked(path, parts)


def _three_each(table: Table, file: CampaignFile, arm: float) -> Table:
    """A 6-D measurement as three points: the target, and `arm` [m] along its x and y. One whose angles nobody
    has told stays as it is."""
    turns = _turns(table, file)
    if table.faults or turns is None:
        return table
    told = {name: table.numbers.pop(name) for name in (*QUATERNION, *ANGLES) if name in table.numbers}
    turn = {name: told[name] for name in (QUATERNION if turns == "quaternion" else ANGLES)}
    names = table.texts.get("target", [next(iter(file.targets), ONLY)] * len(table))
    length = np.linalg.norm(np.stack([*turn.values()], axis=1), axis=1)
    off = np.asarray(~(np.abs(length - 1) <= ROUNDED) if turns == "quaternion" else ~np.isfinite(length))
    turned = {name for name, no_turn in zip(names, off, strict=True) if not no_turn}
    if turned and (plain := [name for name in dict.fromkeys(names) if name not in turned]):
        what = f"no line of {some(plain)} says how it is turned, and {WITHOUT_TURNS}"
        table.faults.append(Fault(str(table.path), what, NO_TURNS))
        return table
    if off.any():
        unseen = "leave out the line of a target that was not seen"
        if turns == "quaternion":
            mend = f"give qw, qx, qy and qz, the scalar as qw; {unseen}"
            table.add_fault_where(off, "qw", "and the three beside it are no quaternion of length 1", mend)
        else:
            table.add_fault_where(off, "rx", "or one of the two beside it is empty", f"give all; {unseen}")
        return table
    R = rotations(turn, turns)
    place = np.stack([table.numbers[axis] for axis in "xyz"], axis=1)
    points = place[:, None] + arm * np.stack([np.zeros_like(place), R[:, :, 0], R[:, :, 1]], axis=1)
    numbers = {name: np.repeat(values, 3) for name, values in table.numbers.items()}
    numbers |= {axis: points[:, :, k].ravel() for k, axis in enumerate("xyz")}
    texts = {name: [cell for cell in cells for _ in range(3)] for name, cells in table.texts.items()}
    texts["target"] = [name + end for name in names for end in ("", "_x", "_y")]
    return Table(table.path, np.repeat(table.lines, 3), numbers, texts, table.labels, table.units)


def _turns(table: Table, file: CampaignFile) -> Turns | None:
    """How its columns say how a target is turned, where that is known; a fault where none do."""
    has = [all(name in table.numbers for name in own) for own in (QUATERNION, ANGLES)]
    told = file.points.turns
    if not any(has) or (told and not has[told != "quaternion"]):
        lacks = "rx, ry, rz" if told not in (None, "quaternion") else "qw, qx, qy, qz"
        mend = "give how the target is turned, or take turned_mm out"
        table.faults.append(Fault(str(table.path), f"no column {lacks}", mend))
    return told or ("quaternion" if has[0] else None)


def undecided(table: Table, file: CampaignFile) -> bool:
    """Whether it is a 6-D measurement whose angles nobody has told: they are still there."""
    return file.points.turned_mm is not None and all(name in table.numbers for name in ANGLES)


def seen_rows(table: Table, whose: str = "") -> Table:
    """Only the rows in which the target was seen; beside them which of how many of it, as `row` of `rows`.
    whose: the target, where the table is of one."""
    if table.faults or not all(axis in table.numbers for axis in XYZ):
        return table
    blank = np.isnan(np.stack([table.numbers[axis] for axis in XYZ], axis=1))
    partly = np.asarray(blank.any(axis=1) & ~blank.all(axis=1))
    for axis, empty in zip(XYZ, blank.T, strict=True):
        table.add_fault_where(partly & empty, axis, f"{whose}is empty", UNSEEN)
    names = table.texts.get("target", [""] * len(table))
    row, count = np.zeros(len(table)), dict[str, int]()
    for at, name in enumerate(names):
        row[at] = count.get(name, 0)
        count[name] = int(row[at]) + 1
    kept = np.flatnonzero(~blank.any(axis=1))
    numbers = table.numbers | {"row": row, "rows": np.array([float(count[name]) for name in names])}
    return Table(
        table.path,
        table.lines[kept],
        {name: values[kept] for name, values in numbers.items()},
        {name: [cells[at] for at in kept] for name, cells in table.texts.items()},
        table.labels,
        table.units,
        table.unused,
        table.faults,
    )


def _stacked(path: Path, parts: Sequence[Table]) -> Table:
    faults = list(dict.fromkeys(fault for part in parts for fault in part.faults))
    if faults:
        return Table(path, faults=faults)
    first = parts[0]
    return Table(
        path,
        np.concatenate([part.lines for part in parts]),
        {name: np.concatenate([part.numbers[name] for part in parts]) for name in first.numbers},
        {name: [cell for part in parts for cell in part.texts[name]] for name in first.texts},
        first.labels,
        first.units,
    )


def number_poses(poses: Table) -> None:
    """Names poses by their row, from 1, where the table does not."""
    poses.texts.setdefault("pose_id", [str(row) for row in range(1, len(poses) + 1)])


def number_points(points: Table, poses: Table) -> bool:
    """Joins points without `pose_id` to the poses in order: the k-th of each target to the k-th pose, a wide
    row to the pose of its row. False where their numbers do not allow it."""
    ids = poses.texts["pose_id"]
    fits = set(points.numbers["rows"]) == {len(ids)}
    if fits:
        points.texts["pose_id"] = [ids[int(row)] for row in points.numbers["row"]]
    return fits
