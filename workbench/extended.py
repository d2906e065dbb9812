"""The extended robot, `model.toml`: the robot's TOML with corrected geometry and the effects found."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from .arm import Array
from .effects import catalogue
from .effects.base import Effect
from .diagnose.result import Where
from .faults import Fault, InputError
from .fit import Fit
from .problem import Problem
from .robot import GEOMETRY, EffectRecord, Robot


def effect_of(record: EffectRecord, robot: Robot) -> tuple[Effect, Array]:
    """Effect and values of a record. Raises InputError for unknown causes or parameters."""
    kind = catalogue().get(record.cause)
    place = f"{robot.path}: effects.{record.cause}"
    if kind is None:
        raise InputError(Fault(place, "no such cause", f"known: {', '.join(catalogue())}"))
    where = Where(record.joint, record.other, record.link, record.payload, record.order)
    settings: dict[str, Any] = dict(record.settings)
    effect = kind(where, record.variant, **settings)
    names = [p.name for p in effect.params]
    if set(names) != set(record.values):
        raise InputError(Fault(place, f"values are {sorted(record.values)}", f"give {names}"))
    return effect, np.array([record.values[name] for name in names])


def record_of(effect: Effect, values: Array) -> EffectRecord:
    """The record of an effect with its values."""
    settings = {
        f.name: getattr(effect, f.name) for f in fields(effect) if f.name not in ("where", "variant")
    }
    return EffectRecord(
        cause=effect.cause,
        variant=effect.variant,
        settings=settings,
        values={p.name: float(v) for p, v in zip(effect.params, values, strict=True)},
        **effect.where.keys(),
    )


def active_effects(problem: Problem) -> tuple[tuple[Effect, Array], ...]:
    """Effects of the robot's model that act in this campaign, with their values."""
    names = problem.campaign.payload_names
    return tuple(
        (effect, values)
        for effect, values in (effect_of(record, problem.robot) for record in problem.robot.effects)
        if (effect.where.payload is None or effect.where.payload in names) and effect.needs(problem) is None
    )


def write_model(path: Path, robot: Robot, geometry: Array, pairs: Sequence[tuple[Effect, Array]]) -> None:
    """Writes the extended robot. geometry: (S, 6) corrections; pairs: all effects with values."""
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
    table["effects"] = [_given(record_of(effect, values).model_dump()) for effect, values in pairs]
    temporary = path.with_name(path.name + ".part")
    temporary.write_text(tomli_w.dumps(table), encoding="utf-8")
    temporary.replace(path)


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
    before = [effect_of(record, model.problem.robot) for record in model.problem.robot.effects]
    found = zip(model.effects, fit.state.values, strict=True)
    write_model(path, model.problem.robot, fit.state.geometry, [*before, *found])
