"""Write a campaign as `campaign.toml`, `poses.csv` and `points.csv`: what `load_campaign` reads."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..files.tables import column_cells, number_text, table_text
from ..files.toml import read_toml, toml_text
from ..files.whole import put_all
from ..robot.description import Robot
from ..robot.find import list_robots
from ..robot.portable import carried
from .cell import CellData
from .data import Array, Campaign
from .file import WRENCH_COLUMNS, pose_columns
from .known import KnownData

Rows = list[list[str]]
OWN = "robot.toml"  # of a robot that is the user's


def write_campaign(
    folder: str | Path, campaign: Campaign, *, shots: Array | None = None, comments: Sequence[str] = ()
) -> Path:
    """Write the campaign into `folder` and return the path of its `campaign.toml`.

    shots: (N, T, S, 3) single shots [m], NaN where there is none, written instead of the means.
    Without them a mean of several shots is written with its own sigma, as far as that is known.
    `comments` go on top of the TOML. A robot of the user's own goes with it as `robot.toml`
    and its URDF. All files are written, or none.
    """
    folder = Path(folder)
    path = folder / "campaign.toml"
    put_all(
        {
            folder / "poses.csv": poses_text(campaign),
            folder / "points.csv": table_text(*_points(campaign, shots)),
            path: campaign_text(folder, campaign, comments),
            **own_robot(folder, campaign.robot),
        }
    )
    return path


def campaign_text(folder: Path, campaign: Campaign, comments: Sequence[str]) -> str:
    """The text of a `campaign.toml` in this folder; `comments` go on top."""
    return toml_text(_campaign_table(folder, campaign), comments)


def poses_text(campaign: Campaign) -> str:
    """The text of `poses.csv`; columns that say nothing are left out."""
    columns = _pose_cells(campaign)
    return table_text(list(columns), zip(*columns.values(), strict=True))


def _campaign_table(folder: Path, campaign: Campaign) -> dict[str, Any]:
    """The content of `campaign.toml`; what is as by default is left out."""
    loads = zip(campaign.payload_names, campaign.load_mass, campaign.load_com, strict=True)
    table: dict[str, Any] = {
        "schema": 1,
        "title": campaign.title,
        "robot": _robot_name(folder, campaign.robot),
        "poses": {"file": "poses.csv"},
        "points": {"file": "points.csv"},
        "targets": {
            target.name: {
                **({} if target.xyz is None else {"xyz_mm": _mm(target.xyz)}),
                **({} if target.on == "flange" else {"on": target.on}),
                **({"fixed": True} if target.fixed else {}),
                **({} if target.opens is None else {"opens": [_rounded(v) for v in target.opens]}),
            }
            for target in campaign.targets
        },
        "noise": {
            **({} if campaign.noise_sigma is None else {"sigma_mm": _rounded(1e3 * campaign.noise_sigma)}),
            **({"pose": True} if campaign.six_dof else {}),
        },
        "known": _known(campaign.known),
        **_cell(folder, campaign.cell),
        "tool": _load(campaign.tool_mass, campaign.tool_com) if campaign.tool_mass > 0.0 else {},
        "payloads": {name: _load(mass, com) for name, mass, com in list(loads)[1:]},
    }
    return {key: value for key, value in table.items() if value != {}}


def _known(known: KnownData) -> dict[str, Any]:
    """Without what is as by default; the scale is in the points already."""
    return known.model_dump(mode="json", exclude_defaults=True, exclude={"scale"})


def _cell(folder: Path, cell: CellData) -> dict[str, Any]:
    """Without what is as by default; meshes by their paths from the folder."""
    table: dict[str, Any] = cell.model_dump(mode="json", exclude_defaults=True)
    for obstacle in table.get("obstacles", ()):
        if "mesh" in obstacle:
            obstacle["mesh"] = Path(os.path.relpath(obstacle["mesh"], folder.resolve())).as_posix()
    return table


def _load(mass: float, com: Iterable[float]) -> dict[str, Any]:
    return {"mass_kg": _rounded(mass), "com_mm": _mm(com)}


def _mm(metres: Iterable[float]) -> list[float]:
    return [_rounded(1e3 * float(value)) for value in metres]


def _rounded(value: float) -> float:
    """As many digits as a table has."""
    return float(number_text(float(value)))


def _robot_name(folder: Path, robot: Robot) -> str:
    """A name where the robot comes with the workbench, a path where it is in the folder already, else that of
    what goes with the campaign."""
    if robot.path is None:
        return robot.name
    path, here = robot.path.resolve(), folder.resolve()
    if path in [known.resolve() for known in list_robots()]:
        return path.stem
    return path.relative_to(here).as_posix() if path.is_relative_to(here) else OWN


def own_robot(folder: Path, robot: Robot) -> dict[Path, str]:
    """The TOML and URDF of a robot that is neither the workbench's nor in the folder: they go with it."""
    if robot.path is None or _robot_name(folder, robot) != OWN:
        return {}
    urdf, text = carried(robot.urdf, folder)
    return {folder / urdf: text, folder / OWN: toml_text(read_toml(robot.path) | {"urdf": urdf})}


def _pose_cells(campaign: Campaign) -> dict[str, Sequence[str]]:
    """Columns of `poses.csv` by their names in the file."""
    known = {column.name: column for column in pose_columns(campaign.robot)}
    cells: dict[str, Sequence[str]] = {"pose_id": campaign.poses.ids}

    def add(names: Iterable[str], values: Array | None) -> None:
        """values: (N, n) [SI], a column each."""
        if values is not None:
            cells.update(
                column_cells(known[name], column) for name, column in zip(names, values.T, strict=True)
            )

    def per_joint(stem: str) -> list[str]:
        return [f"{stem}{index + 1}" for index in range(len(campaign.robot.joints))]

    add(per_joint("q"), campaign.poses.q)
    if np.any(campaign.poses.payload > 0):
        cells["payload"] = [campaign.payload_names[index] for index in campaign.poses.payload]
    if np.any(campaign.poses.wrench != 0.0):
        add([column.name for column in WRENCH_COLUMNS], campaign.poses.wrench)
    add(per_joint("dir"), campaign.poses.side)
    add(["t"], None if campaign.poses.time is None else campaign.poses.time[:, None])
    add(["temp"], None if campaign.poses.temperature is None else campaign.poses.temperature[:, None])
    add(per_joint("tau"), campaign.poses.torque)
    if any(campaign.setup_names):
        cells["setup"] = [campaign.setup_names[index] for index in campaign.poses.setup]
    add(per_joint("r"), campaign.poses.readback)
    return cells


def _points(campaign: Campaign, shots: Array | None) -> tuple[list[str], Rows]:
    """Header and rows of `points.csv`: a row per shot where shots are given, else per mean."""
    values = campaign.points[:, :, None, :] if shots is None else shots
    sigma = _sigma_of_means(campaign) if shots is None else None
    header = ["pose_id", "target", "x_mm", "y_mm", "z_mm"]
    if sigma is not None:
        header += ["sx_mm", "sy_mm", "sz_mm"]
    rows = []
    for pose, target, shot in np.argwhere(np.all(np.isfinite(values), axis=-1)).tolist():
        numbers = [
            *values[pose, target, shot].tolist(),
            *([] if sigma is None else sigma[pose, target].tolist()),
        ]
        texts = [number_text(1e3 * number) for number in numbers]
        rows.append([campaign.poses.ids[pose], campaign.targets[target].name, *texts])
    return header, rows


def _sigma_of_means(campaign: Campaign) -> Array | None:
    """(N, T, 3) sigma to write beside the means; None where `[noise]` says it all."""
    if campaign.sigma is not None or campaign.noise_sigma is None or np.all(campaign.shots <= 1):
        return campaign.sigma
    count = np.maximum(campaign.shots, 1)[..., None]
    return np.repeat(campaign.noise_sigma / np.sqrt(count), 3, axis=2)
