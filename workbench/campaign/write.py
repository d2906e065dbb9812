"""Write a campaign as `campaign.toml`, `poses.csv` and `points.csv`: what `load_campaign` reads."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ..files.tables import number_text, write_table, write_text
from ..robot.description import Joint, Robot
from ..robot.find import list_robots
from .data import Array, Campaign

Rows = list[list[str]]


def write_campaign(
    folder: str | Path, campaign: Campaign, *, shots: Array | None = None, comments: Sequence[str] = ()
) -> Path:
    """Write the campaign into `folder` and return the path of its `campaign.toml`.

    shots: (N, T, S, 3) single shots [m], NaN where there is none, written instead of the means.
    Without them a mean of several shots is written with its own sigma, as far as that is known.
    `comments` go on top of the TOML. Each file is written whole or not at all, the TOML last.
    """
    folder = Path(folder)
    write_table(folder / "poses.csv", *_poses(campaign))
    write_table(folder / "points.csv", *_points(campaign, shots))
    path = folder / "campaign.toml"
    write_text(path, "\n".join([*(f"# {line}" for line in comments), *_toml(folder, campaign)]) + "\n")
    return path


def _toml(folder: Path, campaign: Campaign) -> Iterable[str]:
    yield "schema = 1"
    yield f"title  = {_quoted(campaign.title)}"
    yield f"robot  = {_quoted(_robot_name(folder, campaign.robot))}"
    yield from ("[poses]", 'file = "poses.csv"', "[points]", 'file = "points.csv"')
    for target in campaign.targets:
        yield f"[targets.{_quoted(target.name)}]"
        if target.xyz is not None:
            yield f"xyz_mm = {_vector(target.xyz)}"
        if target.on != "flange":
            yield f"on = {_quoted(target.on)}"
        if target.fixed:
            yield "fixed = true"
    if campaign.noise_sigma is not None or campaign.six_dof:
        yield "[noise]"
        if campaign.noise_sigma is not None:
            yield f"sigma_mm = {_number(1e3 * campaign.noise_sigma)}"
        if campaign.six_dof:
            yield "pose = true"
    if campaign.tool_mass > 0.0:
        yield from ("[tool]", *_load(campaign.tool_mass, campaign.tool_com))
    for name, mass, com in list(
        zip(campaign.payload_names, campaign.load_mass, campaign.load_com, strict=True)
    )[1:]:
        yield from (f"[payloads.{_quoted(name)}]", *_load(mass, com))


def _load(mass: float, com: Iterable[float]) -> list[str]:
    return [f"mass_kg = {_number(mass)}", f"com_mm = {_vector(com)}"]


def _robot_name(folder: Path, robot: Robot) -> str:
    """A name where the robot comes with the workbench, else the path from the folder."""
    if robot.path is None:
        return robot.name
    path = robot.path.resolve()
    if path in [known.resolve() for known in list_robots()]:
        return path.stem
    return Path(os.path.relpath(path, folder.resolve())).as_posix()


def _quoted(text: str) -> str:
    """A TOML string: JSON's, but for the one control character that JSON leaves as it is."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _number(value: float) -> str:
    text = number_text(value)
    return text if any(mark in text for mark in ".en") else f"{text}.0"


def _vector(metres: Iterable[float]) -> str:
    return "[" + ", ".join(_number(1e3 * float(value)) for value in metres) + "]"


def _joint_unit(joint: Joint) -> tuple[str, float]:
    """Suffix and factor of a joint's columns."""
    return ("mm", 1e3) if joint.kind == "prismatic" else ("deg", 180.0 / np.pi)


def _poses(campaign: Campaign) -> tuple[list[str], Rows]:
    """Header and rows of `poses.csv`; columns that say nothing are left out."""
    columns: dict[str, Sequence[str]] = {"pose_id": campaign.pose_ids}
    joints = campaign.robot.joints
    units = [_joint_unit(joint) for joint in joints]

    def per_joint(stem: str, values: Array | None) -> None:
        for index, (suffix, factor) in enumerate(units if values is not None else []):
            assert values is not None
            columns[f"{stem}{index + 1}_{suffix}"] = _texts(values[:, index] * factor)

    per_joint("q", campaign.q)
    if np.any(campaign.payload > 0):
        columns["payload"] = [campaign.payload_names[index] for index in campaign.payload]
    if np.any(campaign.wrench != 0.0):
        for index, name in enumerate(("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")):
            columns[name] = _texts(campaign.wrench[:, index])
    if campaign.direction is not None:
        for index in range(len(joints)):
            columns[f"dir{index + 1}"] = _texts(campaign.direction[:, index])
    if campaign.time is not None:
        columns["t_s"] = _texts(campaign.time)
    if campaign.temperature is not None:
        columns["temp_degC"] = _texts(campaign.temperature)
    if campaign.torque is not None:
        for index, joint in enumerate(joints):
            unit = "N" if joint.kind == "prismatic" else "Nm"
            columns[f"tau{index + 1}_{unit}"] = _texts(campaign.torque[:, index])
    if any(campaign.setup_names):
        columns["setup"] = [campaign.setup_names[index] for index in campaign.setup]
    per_joint("r", campaign.readback)
    return list(columns), [list(row) for row in zip(*columns.values(), strict=True)]


def _texts(values: Array) -> list[str]:
    return [number_text(value) for value in values.tolist()]


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
        rows.append([campaign.pose_ids[pose], campaign.targets[target].name, *texts])
    return header, rows


def _sigma_of_means(campaign: Campaign) -> Array | None:
    """(N, T, 3) sigma to write beside the means; None where `[noise]` says it all."""
    if campaign.sigma is not None or campaign.noise_sigma is None or np.all(campaign.shots <= 1):
        return campaign.sigma
    count = np.maximum(campaign.shots, 1)[..., None]
    return np.repeat(campaign.noise_sigma / np.sqrt(count), 3, axis=2)
