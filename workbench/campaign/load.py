"""Load a campaign: `campaign.toml` and its two tables, joined on `pose_id`."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..files.faults import Fault, InputError
from ..files.tables import Table, read_table, suggest
from ..robot.description import Robot, load_robot
from ..robot.find import find_robot, list_robots
from .check import check_points, check_poses, check_targets, doubts
from .data import Array, Campaign, IntArray, Target
from .file import WRENCH_COLUMNS, CampaignFile, point_columns, pose_columns, read_campaign_file
from .poses import Poses


def load_campaign(path: str | Path) -> Campaign:
    """Load and check a campaign.

    path: its campaign.toml; the tables that it names lie beside it. Columns carry units (`q1_deg`, `x_mm`),
    the campaign is in rad, m, kg, N and s. Raises `InputError` with all faults of all its files at once.

    >>> import numpy as np
    >>> from workbench import Truth, load_robot, planned, random_poses, simulate
    >>> from workbench import load_campaign, write_campaign
    >>> robot = load_robot("cylindrical")
    >>> plan = planned(robot, random_poses(robot, 12, np.random.default_rng(0)))
    >>> path = write_campaign("measured", simulate(plan, Truth(sigma=2e-5)))
    >>> campaign = load_campaign("measured/campaign.toml")
    >>> campaign.poses.q.shape, campaign.points.shape, campaign.noise_sigma
    ((12, 3), (12, 3, 3), 2e-05)
    """
    path = Path(path)
    file = read_campaign_file(path)
    points = read_table(path.parent / file.points.file, file.points, point_columns(file), f"{path}: points")
    faults = [*points.faults, *check_points(points)]
    try:
        robot = _robot(path, file)
    except InputError as error:
        raise InputError([*error.faults, *faults]) from None
    poses = read_table(path.parent / file.poses.file, file.poses, pose_columns(robot), f"{path}: poses")
    faults = [*check_targets(path, file, robot), *poses.faults, *check_poses(poses, file, robot), *faults]
    if not faults:
        faults = _no_match(poses, points)
    if faults:
        raise InputError(faults)
    return _assemble(path, file, robot, poses, points)


def _robot(path: Path, file: CampaignFile) -> Robot:
    """The robot that the campaign names."""
    try:
        found = find_robot(file.robot, beside=path.parent)
    except InputError as error:
        (fault,) = error.faults
        close = suggest(file.robot, [item.stem for item in list_robots()])
        mend = f"{close} {fault.mend}" if close else fault.mend
        raise InputError(Fault(f"{path}: robot = {file.robot!r}", fault.what, mend)) from None
    return load_robot(found)


def _no_match(poses: Table, points: Table) -> list[Fault]:
    told, seen = poses.texts["pose_id"], points.texts["pose_id"]
    if set(told) & set(seen):
        return []
    what = f"no pose_id is among those of {poses.path}: here {_some(seen)}, there {_some(told)}"
    return [Fault(str(points.path), what, "both tables name a pose by the same pose_id")]


@dataclass(frozen=True)
class _Seen:
    """The points table, sorted into the grid poses x targets."""

    targets: tuple[Target, ...]
    points: Array
    shots: IntArray
    sigma: Array | None
    scatter: tuple[float, int]
    warnings: list[str]


def _assemble(path: Path, file: CampaignFile, robot: Robot, poses: Table, points: Table) -> Campaign:
    seen = _sort_points(file, robot, poses, points)
    kept, measured = np.any(seen.shots > 0, axis=1), np.any(seen.shots > 0, axis=0)
    ids = poses.texts["pose_id"]
    warnings = [*seen.warnings, *doubts(poses, points, robot)]
    if not kept.all():
        missing = [name for name, keep in zip(ids, kept, strict=True) if not keep]
        warnings.append(f"{poses.path}: {_poses(missing)} without points, left out")
    payload_names = ("", *file.payloads)
    loads = list(file.payloads.values())
    setups = _column(poses, "setup", kept)
    setup_names = tuple(dict.fromkeys(setups))
    payloads = _column(poses, "payload", kept)
    warnings += [
        f"{path}: payload {name!r} is at no measured pose" for name in file.payloads if name not in payloads
    ]
    n = len(robot.joints)
    nothing = np.zeros(len(poses))
    wrench = [poses.numbers.get(column.name, nothing) for column in WRENCH_COLUMNS]
    direction = _joints(poses, "dir", n, absent=0.0)
    return Campaign(
        title=file.title or path.resolve().parent.name,
        path=path,
        robot=robot,
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
        six_dof=file.noise.pose,
        warnings=tuple(warnings),
        files=_hashes([path, poses.path, points.path, *([robot.path] if robot.path else []), robot.urdf]),
        poses=Poses(
            ids=tuple(_column(poses, "pose_id", kept)),
            q=np.stack([poses.numbers[f"q{joint}"] for joint in range(1, n + 1)], axis=1)[kept],
            payload=np.array([payload_names.index(name) for name in payloads], dtype=np.int64),
            wrench=np.stack(wrench, axis=1)[kept],
            side=None if direction is None else direction[kept],
            time=_optional(poses.numbers.get("t"), kept),
            temperature=_optional(poses.numbers.get("temp"), kept),
            torque=_optional(_joints(poses, "tau", n), kept),
            readback=_optional(_joints(poses, "r", n), kept),
            setup=np.array([setup_names.index(name) for name in setups], dtype=np.int64),
        ),
    )


def _sort_points(file: CampaignFile, robot: Robot, poses: Table, points: Table) -> _Seen:
    """Means of the shots on the grid (pose, target), their numbers, sigma and pooled scatter."""
    names, warnings = _target_names(file, points)
    targets, more = _targets(file, robot, names, points)
    warnings += more
    rows = {pose_id: row for row, pose_id in enumerate(poses.texts["pose_id"])}
    columns = {target.name: column for column, target in enumerate(targets)}
    row = np.array([rows.get(pose_id, -1) for pose_id in points.texts["pose_id"]])
    column = np.array([columns[name] for name in names])
    lost = list(dict.fromkeys(np.array(points.texts["pose_id"])[row < 0].tolist()))
    if lost:
        count = int(np.count_nonzero(row < 0))
        warnings.append(f"{points.path}: {count} points of {_poses(lost)} unknown to {poses.path}, left out")
    grid = (len(poses), len(targets))
    known = row >= 0
    cell = (row * len(targets) + column)[known]
    shots = np.bincount(cell, minlength=grid[0] * grid[1])
    xyz = np.stack([points.numbers[axis] for axis in "xyz"], axis=1)[known]
    with np.errstate(invalid="ignore"):
        mean = _sums(cell, xyz, len(shots)) / shots[:, None]
    sigma = None
    if "sx" in points.numbers:
        stated = np.stack([points.numbers[f"s{axis}"] for axis in "xyz"], axis=1)[known]
        if file.noise.sigma_mm is not None:
            stated = np.where(np.isnan(stated), file.noise.sigma_mm * 1e-3, stated)
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
    (name,) = file.targets
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
        targets.append(Target(name, xyz, on, data.fixed))
        if name not in present:
            warnings.append(f"{points.path}: target {name!r} was never measured, left out")
    for name in present:
        if name not in file.targets:
            line = points.lines[names.index(name)]
            close = suggest(name, file.targets)
            warnings.append(
                f"{points.path} line {line}: target {name!r} is not declared: taken on the flange, its place "
                f"unknown; {close or f'declare [targets.{name}]'}"
            )
            targets.append(Target(name))
    return tuple(targets), warnings


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


def _hashes(paths: Sequence[Path]) -> dict[str, str]:
    return {
        f"{path.resolve().parent.name}/{path.name}": hashlib.sha256(path.read_bytes()).hexdigest()
        for path in paths
    }


def _some(names: Sequence[str], shown: int = 5) -> str:
    unique = list(dict.fromkeys(names))
    return ", ".join(repr(name) for name in unique[:shown]) + (", ..." if len(unique) > shown else "")


def _poses(names: Sequence[str]) -> str:
    count = len(names)
    return f"{count} pose{'s' if count > 1 else ''} ({_some(names)})"
