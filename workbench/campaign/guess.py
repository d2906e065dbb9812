"""How somebody's own tables are laid out, guessed from their text: what `workbench init` proposes.

A guess goes into `campaign.toml`, where people read it; `load_campaign` never guesses.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..robot.chain import MovingJoint
from .exports import program_columns
from .guess_joints import joint_columns, joint_unit, joints_of, odd_joint, windows
from .guess_places import angles, measured, places_of, quaternion
from .guess_text import (
    Array,
    Text,
    any_text,
    counts,
    is_numbers,
    length_unit,
    plain,
    read,
    repeats,
    unit_of,
)
from .guess_times import when
from .program_joints import ARM, joint_table, no_joints, program_of

Misfit = Callable[[Array, Array], float]  # joints (N, n) [rad, m], points (N, 3) [m] → misfit [m]

FITS = 0.03  # of the spread of the points: what the right columns are off the robot at most
CLEARLY = 4.0  # times as far off as the best, or as
EXACT = 1e-3  # of the spread: other columns than the right ones
TURNED = 100.0  # mm along the axes of a 6-D measurement, as far as targets usually are from the flange
NAMING, NAMED = 0.7, 0.5  # of the points that name a pose which is there, and of the poses that are named
ROWS, FEWEST = 60, 8  # of a table, that are looked at
POSE = (
    "poseid", "pose", "posenr", "poseno", "posename", "id", "nr", "no", "nummer", "index", "group", "gruppe",
    "name", "point", "punkt", "punktnr", "messpunkt", "stellung",
)  # fmt: skip
TARGET = (
    "target", "smr", "reflector", "reflektor", "marker", "marke", "ziel", "targetname", "pointname",
    "punktname", "point", "punkt", "name",
)  # fmt: skip
GROUP = ("group", "gruppe")  # of the target, where points name the pose
TEMPERATURE = ("temp", "temperature", "temperatur", "tempdegc", "tempc", "armtemp", "robottemp")  # in °C


@dataclass
class Guessed:
    """Keys for `[poses]` or `[points]`; lacking: our columns that were not found, among `header`; why."""

    keys: dict[str, Any] = field(default_factory=dict)
    lacking: list[str] = field(default_factory=list)
    header: list[str] = field(default_factory=list)
    why: str = ""
    targets: list[str] = field(default_factory=list)  # of a table of points, by name
    payloads: list[str] = field(default_factory=list)  # of a table of joints, in its column `payload`
    ids: list[str] = field(default_factory=list)  # of its poses


def guess_poses(path: Path, joints: Sequence[MovingJoint]) -> Guessed:
    """Keys for the table of a robot's joints, or for a program with positions of them. Raises `InputError`
    where the file cannot be read."""
    words, keys = any_text(path)
    if (program := program_of(words)) is not None:
        rows = joint_table(words, program, path).split("\n")
        found = _of_program(program, keys, joints)
        found.ids = [row.split(",")[0] for row in rows if row]
        return found
    if why := no_joints(words):
        return Guessed(lacking=[f"joint {i}" for i in range(1, len(joints) + 1)], why=why)
    text = read(path)
    found = Guessed(dict(text.keys), header=text.header)
    if "payload" in text.header:
        carried = text.columns[text.header.index("payload")]
        found.payloads = [name for name in dict.fromkeys(carried) if name]
    numbers = joint_columns(text, joints)
    found.why = "" if numbers else odd_joint(text, joints)
    identity = _first(text, POSE, _nameless(text, set(numbers.values())))
    return _of_joints(text, found, joints, numbers, identity)


def _of_program(program: str, keys: Mapping[str, Any], joints: Sequence[MovingJoint]) -> Guessed:
    """Keys for a robot program: its template, and the columns where they are not those of six axes."""
    found = Guessed({"template": program, **keys})
    sliding = [joint.kind == "prismatic" for joint in joints]
    if len(joints) != ARM or any(sliding):
        found.keys["columns"] = program_columns(program, sliding)
    return found


def _of_joints(
    text: Text,
    found: Guessed,
    joints: Sequence[MovingJoint],
    numbers: Mapping[int, int],
    identity: int | None,
) -> Guessed:
    """With the columns of the joints, numbers: joint (from 1) → column, and of the pose's name."""
    columns: dict[str, str | int] = {}
    if not text.header and not numbers:
        found.why = f"it takes {len(joints)} columns of numbers side by side, and nothing else in their cells"
    for i, joint in enumerate(joints, 1):
        if i not in numbers:
            found.lacking.append(f"joint {i}")
            continue
        unit = joint_unit(text, joint, numbers[i], list(numbers.values()))
        columns[f"q{i}_{unit}"] = text.name(numbers[i])
    found.ids = [str(row) for row, _ in enumerate(text.columns[0], 1)] if text.columns else []
    if identity is not None and not repeats(text.columns[identity]):
        columns = {"pose_id": text.name(identity), **columns}
        found.ids = list(text.columns[identity])
    columns |= when(text, set(numbers.values()))
    warmth = _first(text, TEMPERATURE, set(numbers.values())) if text.header else None
    if warmth is not None and is_numbers(text.columns[warmth]) and "f]" not in text.header[warmth].lower():
        columns["temp_degC"] = text.name(warmth)
    return _mapped(found, columns)


def guess_both(path: Path, joints: Sequence[MovingJoint], misfit: Misfit) -> tuple[Guessed, Guessed]:
    """Keys for the joints and for the points of one table. Without a header they are those columns that fit
    the robot as its URDF says, by `misfit`. Raises `InputError` where the file cannot be read."""
    text = read(path)
    if text.header:
        return guess_poses(path, joints), guess_points(path)
    poses, points = Guessed(dict(text.keys)), Guessed(dict(text.keys))
    best = _fitting(text, joints, misfit)
    if best is None:
        poses.lacking, points.lacking = [f"joint {i}" for i in range(1, len(joints) + 1)], ["x", "y", "z"]
        poses.why = points.why = "joints and points in one table without names, and no columns fit the robot"
        return poses, points
    window, places = best
    taken = {*window, *(index for place in places for index in place)}
    first = _first(text, POSE, taken)
    alone = first is not None and text.varies(first) and not repeats(text.columns[first])
    identity = first if alone else None
    triples = {f"T{i}" if len(places) > 1 else "": place for i, place in enumerate(places, 1)}
    return (
        _of_joints(text, poses, joints, dict(enumerate(window, 1)), identity),
        _of_places(text, points, triples, identity, {*range(len(text.columns))}),
    )


def guess_points(path: Path, poses: Sequence[str] = ()) -> Guessed:
    """Keys for the table of the instrument's points. poses: the names of the poses, as far as they are known.
    Raises `InputError` where the file cannot be read."""
    text = read(path)
    found = Guessed(dict(text.keys), header=text.header)
    places, found.why = places_of(text)
    if not places:
        found.lacking += ["x", "y", "z"]
        return found
    taken = {index for triple in places.values() for index in triple}
    return _of_places(text, found, places, _identity(text, taken, poses), taken)


def _of_places(
    text: Text,
    found: Guessed,
    places: Mapping[str, tuple[int, int, int]],
    identity: int | None,
    taken: set[int],
) -> Guessed:
    """With the columns of x, y and z of each target, and of the pose's name; taken: those that name no
    target."""
    own = {index for triple in places.values() for index in triple}
    unit = unit_of(text, min(own)) or length_unit(text, own)
    columns: dict[str, str | int] = {}
    if identity is not None:
        columns["pose_id"] = text.name(identity)
        taken = {*taken, identity}
    columns |= when(text, {*own, *([] if identity is None else [identity])})
    if len(places) == 1:
        several = identity is not None and repeats(text.columns[identity])
        names = (*TARGET, *GROUP) if several else TARGET
        target = _first(text, names, _nameless(text, taken), min(own))
        if target is not None and repeats(text.columns[target]):
            columns["target"] = text.name(target)
            found.targets = list(dict.fromkeys(text.columns[target]))
        (triple,) = places.values()
        columns |= {f"{axis}_{unit}": text.name(i) for axis, i in zip("xyz", triple, strict=True)}
        if turned := quaternion(text) or angles(text):
            columns |= turned
            found.keys["turned_mm"] = TURNED
        return _mapped(found, columns)
    found.targets = list(places)
    found.keys["wide"] = {name: [text.name(i) for i in triple] for name, triple in places.items()}
    if unit != "mm":
        found.keys["units"] = {f"{axis}_mm": unit for axis in "xyz"}
    return _mapped(found, columns)


def _mapped(found: Guessed, columns: dict[str, str | int]) -> Guessed:
    """With the mapping, unless all names are ours already."""
    if any(name != where for name, where in columns.items()):
        found.keys["columns"] = columns
    return found


def _fitting(
    text: Text, joints: Sequence[MovingJoint], misfit: Misfit
) -> tuple[range, list[tuple[int, int, int]]] | None:
    """Columns of joints and of the x, y, z of targets that fit each other; None where none does, or where
    several do."""
    varying = {i for i, column in enumerate(text.columns) if is_numbers(column) and text.varies(i)}
    side_by_side = windows(text, joints)
    found = list[tuple[float, range, tuple[int, int, int]]]()
    for window in side_by_side:
        q = joints_of(text, joints, window)
        for i in sorted(varying):
            place = (i, i + 1, i + 2)
            if not varying.issuperset(place) or not set(window).isdisjoint(place):
                continue
            unit = 1e-3 if length_unit(text, place) == "mm" else 1.0
            points = unit * np.stack([text.numbers(k) for k in place], axis=1)
            rows = np.flatnonzero(np.isfinite(q).all(axis=1) & np.isfinite(points).all(axis=1))
            rows = rows[np.unique(np.linspace(0, len(rows) - 1, ROWS).astype(int))] if len(rows) else rows
            if len(rows) >= FEWEST:
                spread = float(np.linalg.norm(points[rows].std(axis=0)))
                found.append((misfit(q[rows], points[rows]) / spread, window, place))
    found.sort(key=lambda one: one[0])
    if not found or found[0][0] > FITS:
        return None
    best, window, place = found[0]
    limit = min(FITS, CLEARLY * max(best, EXACT))
    if any(value < limit for value, other, _ in found if other != window):
        return None
    places = [place]
    for value, other, place in found:
        if other == window and value < limit:
            places += [place] * all(set(place).isdisjoint(one) for one in places)
    return window, sorted(places)


def _nameless(text: Text, taken: set[int]) -> set[int]:
    """Columns that name nothing: those that are taken; without a header those that were measured as well."""
    return taken if text.header else {*taken, *measured(text)}


def _identity(text: Text, taken: set[int], poses: Sequence[str]) -> int | None:
    """The column of the pose's name in a table of points: one that holds the names of the `poses`; else as it
    is called, unless it numbers the points and not the poses."""
    called = _first(text, POSE, _nameless(text, taken))
    holding = [
        i
        for i, column in enumerate(text.columns)
        if i not in taken and _hold(column, poses) and (i == called or not counts(column))
    ]
    if holding:
        return called if called in holding else holding[0]
    return None if called is not None and poses and counts(text.columns[called]) else called


def _hold(column: Sequence[str], poses: Sequence[str]) -> bool:
    """Whether most cells are names of poses, and most poses have one."""
    names = set(poses)
    return (
        sum(cell in names for cell in column) >= NAMING * len(column)
        and len(names.intersection(column)) >= NAMED * len(names) > 0
    )


def _first(text: Text, names: Sequence[str], taken: set[int], before: int | None = None) -> int | None:
    """The first column that is called so; without a header, the first one left that varies, else the last
    one left `before` a column."""
    left = [i for i in range(len(text.columns)) if i not in taken]
    if not text.header:
        alike = [i for i in left if before is None or i < before] or left
        return next((i for i in left if text.varies(i)), alike[-1] if alike else None)
    called = {plain(text.header[i]): i for i in reversed(left)}
    return next((called[name] for name in names if name in called), None)
