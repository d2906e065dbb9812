"""The extended robot, `model.toml`: the robot's TOML with corrected geometry and the effects found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..campaign import Campaign
from ..campaign.problem import Problem
from ..effects.records import record
from ..files.tables import number_text
from ..files.toml import toml_text
from ..files.whole import put_all
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.portable import carried
from ..robot.schema import GEOMETRY, EffectRecord, LoadData
from .fit import Fit
from .own_base import own_base
from .prediction.of_fit import uncertainty

Files = dict[Path, str]
UNMOVED = 1e-9  # m, rad: of a frame that is held where it was stated a fit makes less


def write_model(path: str | Path, robot: Robot, geometry: Array, effects: Sequence[EffectRecord]) -> None:
    """Writes the extended robot to `path` and its URDF beside it, both or none; `load_robot` reads it back.

    geometry: (S, 6) tx ty tz rx ry rz [m, rad], corrections of the arm's slots; effects: all of them.
    """
    put_all(model_files(Path(path), robot, geometry, effects))


def model_files(path: Path, robot: Robot, geometry: Array, effects: Sequence[EffectRecord]) -> Files:
    """The extended robot as it is to stand at `path`, and its URDF beside it; for any S slots of the arm.

    geometry: (S, 6) tx ty tz rx ry rz [m, rad] corrections; effects: all of them.
    """
    urdf, text = carried(robot.urdf, path.parent)
    table: dict[str, Any] = {
        "schema": 1,
        "name": robot.name,
        "title": robot.title,
        "urdf": urdf,
        "flange": robot.flange,
        "base": robot.base,
        "gravity": list(robot.gravity),
        "joints": [
            {"name": joint.name, **_given(joint.data.model_dump(exclude={"name"}))} for joint in robot.joints
        ],
    }
    if robot.pose_repeatability_mm is not None:
        table["pose_repeatability_mm"] = robot.pose_repeatability_mm
    if robot.compensator is not None:
        table["compensator"] = _given(robot.compensator.model_dump())
    if robot.bending_stiffness:
        table["links"] = [{"name": k, "bending_stiffness": v} for k, v in robot.bending_stiffness.items()]
    if controller := robot.controller.model_dump(mode="json", exclude_defaults=True):
        table["controller"] = controller
    if robot.source:
        table["source"] = robot.source
    if robot.mounted:
        table["mounted"] = robot.mounted
    if robot.tool is not None:
        table["tool"] = _given(robot.tool.model_dump())
    if robot.payloads:
        table["payloads"] = {name: _given(load.model_dump()) for name, load in robot.payloads.items()}
    table["geometry"] = {
        name: {key: float(v) for key, v in zip(GEOMETRY, geometry[i + 1], strict=True)}
        for i, name in enumerate(robot.corrected_frames)
        if np.abs(geometry[i + 1]).max() > UNMOVED
    }
    table["effects"] = [_given(item.model_dump()) for item in effects]
    if robot.uncertainty is not None:
        table["prediction"] = robot.uncertainty.model_dump(mode="json", exclude_none=True)
    return {path.parent / urdf: text, path: toml_text(table)}


def _given(table: dict[str, Any]) -> dict[str, Any]:
    """Without what is not known, tuples as lists."""
    return {
        key: list(value) if isinstance(value, tuple) else value
        for key, value in table.items()
        if value is not None and value != {}
    }


def write_fit(path: str | Path, fit: Fit) -> None:
    """Writes a fit as the extended robot; see `fit_files`."""
    put_all(fit_files(Path(path), fit))


def fit_files(path: Path, fit: Fit) -> Files:
    """A fit as the extended robot (`as_robot`) that is to stand at `path`."""
    robot, geometry = _extended(fit)
    return model_files(path, robot, geometry, robot.effects)


def as_robot(fit: Fit) -> Robot:
    """A fit as the extended robot, in its own base: what of it lasts (`Fit.lasting`), beside what the robot's
    model had already. Tool and payloads are the campaign's: the effects were found under them; payloads of
    the model that the campaign does not name stay."""
    robot, geometry = _extended(fit)
    return robot.corrected(geometry)


def _extended(fit: Fit) -> tuple[Robot, Array]:
    """The extended robot without its geometry, and that."""
    fit = fit.lasting
    model = fit.model
    given = [(item.effect, v[None]) for item, v in zip(model.given, fit.state.given, strict=True) if v]
    values = [*given, *zip(model.effects, fit.state.values, strict=True)]
    found = [(effect, v) for effect, v in values if effect.lasting]
    robot = loaded(model.problem.robot, model.problem.campaign)
    elsewhere = _of_kept_loads(model.problem)
    base = own_base(model.problem, fit.state.geometry)
    x, y, z = base.gravity.tolist()
    # in the order of the prediction's names
    effects = (*elsewhere, *(record(effect, v) for effect, v in (*model.known, *found)))
    robot = replace(robot, uncertainty=uncertainty(fit), gravity=(x, y, z), effects=effects)
    return robot, base.geometry


def _of_kept_loads(problem: Problem) -> list[EffectRecord]:
    """What the model has of loads that stay in it (`loaded`) and that this campaign does not carry."""
    here = {*problem.campaign.payload_names[1:], problem.campaign.tool_name}
    kept = problem.robot.payloads.keys() - here
    return [item for item in problem.robot.effects if item.payload in kept]


def loaded(robot: Robot, campaign: Campaign) -> Robot:
    """The robot with the tool and payloads of a campaign, beside payloads of its own by other names."""
    tool = _load(campaign.tool_mass, campaign.tool_com) if campaign.tool_mass > 0 else None
    payloads = {name: _load(*load) for name, load in campaign.payloads.items()}
    return replace(robot, tool=tool, payloads={**robot.payloads, **payloads}, mounted=campaign.mounted)


def _load(mass: float, com: Array) -> LoadData:
    x, y, z = (float(number_text(1e3 * float(c))) for c in com)
    return LoadData(mass_kg=mass, com_mm=(x, y, z))
