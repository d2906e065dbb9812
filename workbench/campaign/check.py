"""What can be wrong with a campaign beyond its cells: references, repeated names, doubtful sizes."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

import numpy as np

from ..files.clock import DAY
from ..files.faults import Fault
from ..files.tables import FAULTS_SHOWN, Table, suggest
from ..files.toml import toml_key
from ..robot.description import Robot
from .file import CampaignFile
from .in_motion import in_motion

LONGEST_DAYS = 60.0  # that a campaign lasts, from which the unit of time is doubted


def check_targets(path: Path, file: CampaignFile, robot: Robot) -> list[Fault]:
    """Targets sit on the flange, the base or a link of the robot."""
    places = list(dict.fromkeys(["flange", "base", robot.flange, robot.base, *robot.links]))
    return [
        Fault(f"{path}: targets.{toml_key(name)}.on", f"{robot.name} has no link {target.on!r}",
              suggest(target.on, places) or f"one of {places}")
        for name, target in file.targets.items()
        if target.on not in places
    ]  # fmt: skip


def check_poses(poses: Table, robot: Robot, payloads: Collection[str] | None = None) -> list[Fault]:
    """Faults of `poses.csv` beyond single cells. payloads: those that it may name; None: any."""
    n = len(robot.joints)
    table = Table(poses.path, poses.lines, poses.numbers, poses.texts, poses.labels)
    for name in poses.unused:
        index = re.match(r"(?:q|r|tau|dir)(\d+)(?:_|$)", name)
        if index and not 1 <= int(index[1]) <= n:
            what = f"column {name!r}, but {robot.name} has {n} joints"
            table.faults.append(Fault(str(poses.path), what, "take it out, or mend `robot`"))
    for names in (_all(n, "r"), _all(n, "tau")):
        given = [name for name in names if name in poses.labels]
        if given and len(given) < n:
            absent = ", ".join(name for name in names if name not in given)
            table.faults.append(
                Fault(str(poses.path), f"{given[0]} but no {absent}", f"give all {n} joints or none")
            )
    _check_unique(table)
    if payloads is not None and "payload" in table.texts:
        known = ["", *payloads]
        rows = [row for row, name in enumerate(table.texts["payload"]) if name not in known]
        names = [table.texts["payload"][row] for row in rows]
        told = ", ".join(payloads) or "none"
        mends = [suggest(name, payloads) or f"[payloads] has: {told}; empty = no payload" for name in names]
        table.add_faults(rows, [f"payload {name!r} is not declared" for name in names], mends)
    for name in _all(n, "dir"):
        if name in table.numbers:
            values = table.numbers[name]
            wrong = ~np.isin(values, (-1.0, 0.0, 1.0)) & np.isfinite(values)
            table.add_fault_where(wrong, name, "is not a sign", "write -1, 0 or 1 (0: none or not known)")
    return table.faults


def _all(n: int, stem: str) -> list[str]:
    return [f"{stem}{joint}" for joint in range(1, n + 1)]


def _check_unique(table: Table) -> None:
    lines: dict[str, list[int]] = {}
    if "pose_id" not in table.texts:
        return
    for name, line in zip(table.texts["pose_id"], table.lines.tolist(), strict=True):
        lines.setdefault(name, []).append(line)
    repeated = {name: places for name, places in lines.items() if name and len(places) > 1}
    mend = "every row is a pose with a name of its own"
    for name in list(repeated)[:FAULTS_SHOWN]:
        often = "twice" if len(repeated[name]) == 2 else f"{len(repeated[name])} times"
        what = f"pose_id {name!r} {often}, lines {_and(repeated[name])}"
        table.faults.append(Fault(str(table.path), what, mend))
    if len(repeated) > FAULTS_SHOWN:
        what = f"{len(repeated) - FAULTS_SHOWN} more pose_ids several times"
        table.faults.append(Fault(str(table.path), what, mend))


def _and(numbers: list[int]) -> str:
    texts = [str(number) for number in numbers]
    if len(texts) > 5:
        return ", ".join(texts[:5]) + ", ..."
    return ", ".join(texts[:-1]) + " and " + texts[-1]


def check_points(points: Table, stated: bool) -> list[Fault]:
    """Faults of `points.csv` beyond single cells. stated: so is [noise] sigma_mm, and an uncertainty of 0 is
    none."""
    table = Table(points.path, points.lines, points.numbers, points.texts, points.labels)
    given = [axis for axis in "xyz" if f"s{axis}" in points.labels]
    if given and len(given) < 3:
        absent = ", ".join(f"s{axis}_mm" for axis in "xyz" if axis not in given)
        table.faults.append(Fault(str(points.path), f"s{given[0]} but no {absent}", "give all three or none"))
    for axis in given:
        table.add_fault_where(
            points.numbers[f"s{axis}"] < 0.0, f"s{axis}", "is below 0", "an uncertainty is positive"
        )
    if not stated:
        table.faults += _without_uncertainty(table, [f"s{axis}" for axis in given])
    return table.faults


def _without_uncertainty(points: Table, given: list[str]) -> list[Fault]:
    """A fault where an instrument writes an uncertainty of 0, as it does where it has none: one for all."""
    if not given:
        return []
    none = np.any([points.numbers[name] == 0.0 for name in given], axis=0)
    if not none.any():
        return []
    place = f"{points.path} line {points.lines[int(np.argmax(none))]}"
    columns = ", ".join(points.labels[name] for name in given)
    what = f"{columns}: an uncertainty of 0 ({np.count_nonzero(none)} of {len(none)} lines) is none"
    mend = "state [noise] sigma_mm, which then holds for these, or take the columns out"
    return [Fault(place, what, mend)]


def doubts(poses: Table, points: Table, robot: Robot) -> list[str]:
    """Numbers of a doubtful size, as warnings: they may be right."""
    warnings = []
    for index, joint in enumerate(robot.joints, 1):
        name, q = f"q{index}", poses.numbers[f"q{index}"]
        label, largest = poses.labels[name], int(np.argmax(np.abs(q)))
        if joint.kind == "revolute" and abs(q[largest]) > 100.0:
            place = f"{poses.path} line {poses.lines[largest]}"
            warnings.append(
                f"{place}: {label} turns {abs(q[largest]) / (2 * np.pi):.2g} times; are these degrees?"
            )
            continue
        beyond = joint.beyond(q)
        if beyond.any():
            place = f"{poses.path} line {poses.lines[int(np.argmax(beyond))]}"
            count = int(np.count_nonzero(beyond))
            warnings.append(
                f"{place}: {label} beyond the limits of {joint.name} (at {count} of {len(q)} poses)"
            )
    xyz = np.stack([points.numbers[axis] for axis in "xyz"], axis=1)
    far = float(np.max(np.abs(xyz)))
    if far > 200.0:
        warnings.append(f"{points.path}: points {far:.6g} m away; is the unit right?")
    elif far < 0.02:
        warnings.append(
            f"{points.path}: all points within {1e3 * far:.1f} mm of the origin; are these metres?"
        )
    nothing = np.flatnonzero(np.all(xyz == 0.0, axis=1))
    if len(nothing):
        place = f"{points.path} line {points.lines[nothing[0]]}"
        warnings.append(
            f"{place}: point at exactly 0 0 0 ({len(nothing)} such lines); not seen? leave it out"
        )
    temperature = poses.numbers.get("temp")
    if temperature is not None and np.any((temperature < -30.0) | (temperature > 65.0)):
        warnings.append(f"{poses.path}: {poses.labels['temp']} is outside -30 .. 65 degC; is the unit right?")
    return [*warnings, *_doubtful_time(poses), *_moving(poses, robot), *_unused(poses), *_unused(points)]


def _doubtful_time(poses: Table) -> list[str]:
    """Times that are no seconds of one clock, in the order of measurement."""
    time = poses.numbers.get("t")
    if time is None or not np.isfinite(time).any():
        return []
    label, days = poses.labels["t"], float(np.nanmax(time) - np.nanmin(time)) / DAY
    if days > LONGEST_DAYS:
        return [f"{poses.path}: by {label} the campaign lasts {days:.0f} days; are these seconds?"]
    setups = np.array(poses.texts.get("setup", [""] * len(time)))
    back = np.flatnonzero((np.diff(time) < 0) & (setups[1:] == setups[:-1]))
    if not len(back):
        return []
    place = f"{poses.path} line {poses.lines[back[0] + 1]}"
    return [f"{place}: {label} is earlier than in the line before ({len(back)} such lines); is it one clock?"]


def _moving(poses: Table, robot: Robot) -> list[str]:
    """That the rows were measured while the arm moved."""
    q = np.column_stack([poses.numbers[name] for name in _all(len(robot.joints), "q")])
    apart = in_motion(q, poses.numbers.get("t"))
    if not apart:
        return []
    when = f"{apart:.2g} s apart by {poses.labels['t']}"
    return [
        f"{poses.path}: the joints move from row to row, {when}: measured in motion. What the arm lags "
        "behind, and noise that is alike in neighbouring rows, count as errors at rest here; measure it "
        "standing, a second or more at each pose, to know its errors"
    ]


def _unused(table: Table) -> list[str]:
    """Columns that nobody asked for, worth a word in a file of our own layout."""
    return [f"{table.path}: column {name!r} is not used" for name in table.unused]
