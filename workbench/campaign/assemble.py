"""A campaign from its checked tables: joined on `pose_id`, shots as means on the grid pose × target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..files.digest import digests
from ..files.tables import Table, suggest
from ..files.toml import toml_key
from ..robot.description import Robot
from ..robot.shown import urdf_notes
from .cell import beside
from .check import doubts
from .data import Array, Campaign, IntArray, Target
from .file import ANGLES, QUATERNION, WRENCH_COLUMNS, CampaignFile
from .path_sides import sides_along
from .poses import Poses

ONLY = "T1"  # name of the only target where nobody names it


@dataclass(frozen=True)
class _Seen:
    """The points table, sorted into the grid poses x targets."""

    targets: tuple[Target, ...]
    points: Array
    shots: IntArray
    sigma: Array | None
    scatter: tuple[float, int]
    warnings: list[str]


def assemble(path: Path, file: CampaignFile, robot: Robot, poses: Table, points: Table) -> Campaign:
    """The campaign of a checked file and its checked tables; `path` is what messages call it."""
    _timed_by_points(poses, points)
    seen = _sort_points(file, robot, poses, points)
    kept, measured = np.any(seen.shots > 0, axis=1), np.any(seen.shots > 0, axis=0)
    warnings = [*urdf_notes(robot), *seen.warnings, *doubts(poses, points, robot)]
    if not kept.all():
        missing = [name for name, keep in zip(poses.texts["pose_id"], kept, strict=True) if not keep]
        warnings.append(f"{poses.path}: {_poses(missing)} without points, left out")
    payload_names, loads = ("", *file.payloads), list(file.payloads.values())
    setup_names = tuple(dict.fromkeys(_column(poses, "setup", kept)))
    carried = _column(poses, "payload", kept)
    warnings += [
        f"{path}: payload {name!r} is at no measured pose" for name in file.payloads if name not in carried
    ]
    q = np.stack([poses.numbers[f"q{joint}"] for joint in range(1, len(robot.joints) + 1)], axis=1)
    side, along = _sides(poses, q)
    return Campaign(
        title=file.title or path.resolve().parent.name,
        path=path,
        robot=robot,
        poses=_kept_poses(poses, kept, q, side, payload_names, setup_names),
        payload_names=payload_names,
        load_mass=np.array([0.0, *(load.mass_kg for load in loads)]),
        load_com=np.array([(0.0, 0.0, 0.0), *(load.com_mm for load in loads)]) * 1e-3,
        tool_mass=file.tool.mass_kg,
        tool_com=np.array(file.tool.com_mm) * 1e-3,
        setup_names=setup_names,
        targets=tuple(target for target, keep in zip(seen.targets, measured, strict=True) if keep),
        points=seen.points[kept][:, measured],
        shots=seen.shots[kept][:, measured],
        sigma=None if seen.sigma is None else seen.sigma[kept][:, measured],
        shot_scatter=seen.scatter,
        noise_sigma=None if file.noise.sigma_mm is None else file.noise.sigma_mm * 1e-3,
        six_dof=file.noise.pose or file.points.turned_mm is not None,
        warnings=(*warnings, *along),
        cell=beside(file.cell, path),
        known=file.known.model_copy(update={"scale": 1.0}),
        files=digests([path, poses.path, points.path, *robot.files]),
    )


def _rows(poses: Table, points: Table) -> IntArray:
    """(M,) the row of each point's pose; -1 of one that is not among them."""
    rows = {pose_id: row for row, pose_id in enumerate(poses.texts["pose_id"])}
    return np.array([rows.get(pose_id, -1) for pose_id in points.texts["pose_id"]], dtype=np.int64)


def _timed_by_points(poses: Table, points: Table) -> None:
    """Gives poses the mean time of their points, where the instrument wrote it down and the robot did not."""
    if "t" in poses.numbers or "t" not in points.numbers:
        return
    row, when = _rows(poses, points), points.numbers["t"]
    used = (row >= 0) & np.isfinite(when)
    count = np.bincount(row[used], minlength=len(poses))
    with np.errstate(invalid="ignore"):
        poses.numbers["t"] = np.bincount(row[used], when[used], minlength=len(poses)) / count
    poses.labels["t"] = points.labels["t"]


def _kept_poses(
    poses: Table,
    kept: NDArray[np.bool_],
    q: Array,
    side: Array | None,
    payload_names: Sequence[str],
    setup_names: Sequence[str],
) -> Poses:
    """What the robot was told in the kept rows, of joints q (rows, n); side: (rows, n) of approach."""
    n, nothing = q.shape[1], np.zeros(len(poses))
    wrench = [poses.numbers.get(column.name, nothing) for column in WRENCH_COLUMNS]
    payload, setup = _column(poses, "payload", kept), _column(poses, "setup", kept)
    return Poses(
        ids=tuple(_column(poses, "pose_id", kept)),
        q=q[kept],
        payload=np.array([payload_names.index(name) for name in payload], dtype=np.int64),
        wrench=np.stack(wrench, axis=1)[kept],
        side=None if side is None else side[kept],
        time=_optional(poses.numbers.get("t"), kept),
        temperature=_optional(poses.numbers.get("temp"), kept),
        torque=_optional(_joints(poses, "tau", n), kept),
        readback=_optional(_joints(poses, "r", n), kept),
        setup=np.array([setup_names.index(name) for name in setup], dtype=np.int64),
    )


def _sides(poses: Table, q: Array) -> tuple[Array | None, list[str]]:
    """(rows, n) sides of approach at joints q (rows, n), as stated or along a path; None where nobody knows.
    And a remark."""
    n = q.shape[1]
    stated = _joints(poses, "dir", n, absent=0.0)
    if stated is not None:
        return stated, []
    every = _column(poses, "setup", np.ones(len(poses), dtype=bool))
    found = sides_along(q, np.unique(every, return_inverse=True)[1], poses.numbers.get("t"))
    if found is None:
        return None, []
    said = (
        f"{poses.path}: no column dir1 … dir{n}; the poses follow each other along a path, and the sides of"
    )
    return found, [f"{said} approach are taken from that"]


def _sort_points(file: CampaignFile, robot: Robot, poses: Table, points: Table) -> _Seen:
    """Means of the shots on the grid (pose, target), their numbers, sigma and pooled scatter."""
    names, warnings = _target_names(file, points)
    for own in (QUATERNION, ANGLES):
        if own[0] in points.numbers:
            all_turned = np.isfinite(points.numbers[own[0]]).all()
            use = "; turned_mm = 100 under [points] makes three points of each" if all_turned else ""
            warnings.append(f"{points.path}: {', '.join(own)}, how the target is turned, are not used{use}")
    targets, more = _targets(file, robot, names, points)
    warnings += more
    columns = {target.name: column for column, target in enumerate(targets)}
    row = _rows(poses, points)
    column = np.array([columns[name] for name in names])
    lost = list(dict.fromkeys(points.texts["pose_id"][i] for i in np.flatnonzero(row < 0)))
    if lost:
        count = int(np.count_nonzero(row < 0))
        warnings.append(f"{points.path}: {count} points of {_poses(lost)} unknown to {poses.path}, left out")
    grid = (len(poses), len(targets))
    known = row >= 0
    cell = (row * len(targets) + column)[known]
    shots = np.bincount(cell, minlength=grid[0] * grid[1])
    xyz = file.known.scale * np.stack([points.numbers[axis] for axis in "xyz"], axis=1)[known]
    with np.errstate(invalid="ignore"):
        mean = _sums(cell, xyz, len(shots)) / shots[:, None]
    sigma = None
    if "sx" in points.numbers:
        stated = np.stack([points.numbers[f"s{axis}"] for axis in "xyz"], axis=1)[known]
        if file.noise.sigma_mm is not None:
            none = np.isnan(stated) | (stated == 0.0)  # as instruments write that they have none
            stated = np.where(none, file.noise.sigma_mm * 1e-3, stated)
        with np.errstate(invalid="ignore"):
            sigma = (np.sqrt(_sums(cell, stated**2, len(shots))) / shots[:, None]).reshape(*grid, 3)
    with np.errstate(over="ignore"):  # beyond all measure: left out later
        square = float(np.sum((xyz - mean[cell]) ** 2))
    scatter = square, 3 * int(np.sum(np.maximum(shots - 1, 0)))
    return _Seen(targets, mean.reshape(*grid, 3), shots.reshape(grid), sigma, scatter, warnings)


def _sums(cell: NDArray[np.int64], values: Array, count: int) -> Array:
    return np.stack([np.bincount(cell, weights=axis, minlength=count) for axis in values.T], axis=1)


def _target_names(file: CampaignFile, points: Table) -> tuple[list[str], list[str]]:
    if "target" in points.texts:
        return points.texts["target"], []
    name = next(iter(file.targets), ONLY)
    return [name] * len(points), [f"{points.path}: no column target, so all points are of {name!r}"]


def _targets(
    file: CampaignFile, robot: Robot, names: Sequence[str], points: Table
) -> tuple[tuple[Target, ...], list[str]]:
    """The declared targets, then those that only the points name."""
    warnings = []
    targets = []
    present = dict.fromkeys(names)
    for name, data in file.targets.items():
        xyz = (
            None
            if data.xyz_mm is None
            else (data.xyz_mm[0] * 1e-3, data.xyz_mm[1] * 1e-3, data.xyz_mm[2] * 1e-3)
        )
        on = {robot.flange: "flange", robot.base: "base"}.get(data.on, data.on)
        targets.append(Target(name, xyz, on, data.fixed, data.opens))
        if name not in present:
            warnings.append(f"{points.path}: target {name!r} was never measured, left out")
    unknown = [name for name in present if name not in file.targets]
    targets += [Target(name) for name in unknown]
    if file.points.turned_mm is not None:  # that makes targets of its own
        return tuple(targets), warnings
    return tuple(targets), warnings + _undeclared(unknown, file, names, points)


def _undeclared(unknown: Sequence[str], file: CampaignFile, names: Sequence[str], points: Table) -> list[str]:
    """What is said of targets that only the points name: each that may be a slip, the others together."""
    slips = {name: close for name in unknown if (close := suggest(name, file.targets))}
    told = []
    for name, close in slips.items():
        line = points.lines[names.index(name)]
        told.append(
            f"{points.path} line {line}: target {name!r} is not declared: taken on the flange, its place "
            f"unknown; {close}"
        )
    if new := [name for name in unknown if name not in slips]:
        line = points.lines[names.index(new[0])]
        which = f"target {new[0]!r} is" if len(new) == 1 else f"targets {some(new)} are"
        place = "its place" if len(new) == 1 else "their places"
        more = " and so on" if len(new) > 1 else ""
        told.append(
            f"{points.path} line {line}: {which} not declared: taken on the flange, {place} unknown; "
            f"declare [targets.{toml_key(new[0])}]{more}"
        )
    return told


def _column(table: Table, name: str, kept: NDArray[np.bool_]) -> list[str]:
    cells = table.texts.get(name, [""] * len(table))
    return [cell for cell, keep in zip(cells, kept, strict=True) if keep]


def _joints(table: Table, stem: str, n: int, absent: float = np.nan) -> Array | None:
    """(rows, n) of `stem`1..n, `absent` where a column is not there; None when none is."""
    if not any(f"{stem}{joint}" in table.numbers for joint in range(1, n + 1)):
        return None
    empty = np.full(len(table), absent)
    return np.stack([table.numbers.get(f"{stem}{joint}", empty) for joint in range(1, n + 1)], axis=1)


def _optional(values: Array | None, kept: NDArray[np.bool_]) -> Array | None:
    """The kept rows; None when not one of them has a number."""
    return None if values is None or np.isnan(values[kept]).all() else values[kept]


def some(names: Sequence[str]) -> str:
    unique = list(dict.fromkeys(names))
    return ", ".join(repr(name) for name in unique[:5]) + (", ..." if len(unique) > 5 else "")


def _poses(names: Sequence[str]) -> str:
    count = len(names)
    return f"{count} pose{'s' if count > 1 else ''} ({some(names)})"
