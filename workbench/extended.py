"""The extended robot, `model.toml`: the robot's TOML with corrected geometry and the effects found."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomli_w

from .arm import Array
from .atomic import put
from .fit import Fit
from .records import record
from .robot import GEOMETRY, EffectRecord, Robot


def write_model(path: Path, robot: Robot, geometry: Array, effects: Sequence[EffectRecord]) -> None:
    """Writes the extended robot. geometry: (S, 6) corrections; effects: all of them."""
    table: dict[str, Any] = {
        "schema": 1,
        "name": robot.name,
        "title": robot.title,
        "urdf": os.path.relpath(robot.urdf.resolve(), path.parent.resolve()),
        "flange": robot.flange,
        "gravity": list(robot.gravity),
        "joints": [
            {"name": joint.name, **_given(joint.data.model_dump(exclude={"name"}))} for joint in robot.joints
        ],
    }
    if robot.compensator is not None:
        table["compensator"] = _given(robot.compensator.model_dump())
    if robot.bending_stiffness:
        table["links"] = [{"name": k, "bending_stiffness": v} for k, v in robot.bending_stiffness.items()]
    if robot.source:
        table["source"] = robot.source
    table["geometry"] = {
        name: {key: float(v) for key, v in zip(GEOMETRY, geometry[i + 1], strict=True)}
        for i, name in enumerate(robot.joint_names)
        if geometry[i + 1].any()
    }
    table["effects"] = [_given(item.model_dump()) for item in effects]
    put(path, tomli_w.dumps(table).encode())


def _given(table: dict[str, Any]) -> dict[str, Any]:
    """Without what is not known, tuples as lists."""
    return {
        key: list(value) if isinstance(value, tuple) else value
        for key, value in table.items()
        if value is not None and value != {}
    }


def write_fit(path: Path, fit: Fit) -> None:
    """Writes a fit as the extended robot: what it found, beside what the robot's model had already."""
    model = fit.model
    found = [record(e, v) for e, v in zip(model.effects, fit.state.values, strict=True)]
    robot = model.problem.robot
    write_model(path, robot, fit.state.geometry, [*robot.effects, *found])
