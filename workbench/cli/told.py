"""What a simulated robot is told: poses of a file, on a grid or at random, and what goes with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..campaign.check import check_poses
from ..campaign.file import pose_columns
from ..campaign.payloads import Load
from ..campaign.planned import random_poses
from ..campaign.problem import REFERENCE_TEMPERATURE, filled
from ..files.faults import Fault, InputError
from ..files.tables import Layout, read_table
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.schema import stated_load
from .arguments import MOST

MOST_TURNED = 100.0  # rad: no joint turns so far


@dataclass(frozen=True)
class Told:
    """What the robot is told in N poses, as in `Campaign`; payload: (N,) names, empty while none are said;
    ids: (N) of a file that names its poses, and setup."""

    q: Array
    payload: Sequence[str] = ()
    wrench: Array | None = None
    direction: Array | None = None
    time: Array | None = None
    temperature: Array | None = None
    readback: Array | None = None
    setup: Sequence[str] | None = None
    ids: tuple[str, ...] = ()

    def with_and_without(self, payloads: Sequence[str]) -> Told:
        """Every pose without and with each payload, unless a file said which."""
        if self.payload:
            return self
        copies, count = 1 + len(payloads), len(self.q)
        carried = [name for name in ["", *payloads] for _ in range(count)]
        every = self._rows(np.tile(np.arange(count), copies))
        return replace(every, payload=carried, ids=self.ids if copies == 1 else ())

    def over(self, hours: float, shuffled: np.random.Generator | None) -> Told:
        """At even times, in random order if `shuffled`, unless a file said when."""
        if hours <= 0 or self.time is not None:
            return self
        time = np.linspace(0, 3600 * hours, len(self.q))
        told = self if shuffled is None else self._rows(shuffled.permutation(len(self.q)))
        return replace(told, time=time)

    def _rows(self, rows: NDArray[np.int64]) -> Told:
        """What it is told in these of its poses."""
        parts: dict[str, Any] = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, value in parts.items():
            if isinstance(value, np.ndarray):
                parts[name] = value[rows]
            elif value:
                parts[name] = tuple(value[i] for i in rows)
        return Told(**parts)

    def warming_up(self, rise: float) -> Told:
        """From 20 °C up by `rise` [K] in three time constants, unless a file said how warm."""
        if not rise or self.temperature is not None:
            return self
        share = np.linspace(0, 1, len(self.q)) if self.time is None else self.time / self.time.max()
        grown = (1 - np.exp(-3 * share)) / (1 - np.exp(-3))
        return replace(self, temperature=REFERENCE_TEMPERATURE + rise * grown)

    def approached(self, rng: np.random.Generator) -> Told:
        """From random sides, unless a file said from which."""
        if self.direction is not None:
            return self
        return replace(self, direction=rng.choice([-1.0, 1.0], size=self.q.shape))


def from_file(robot: Robot, file: str, loads: dict[str, Load]) -> tuple[Told, dict[str, Load]]:
    """The poses of a file, with the payloads, wrenches, sides, times and temperatures that it gives; and the
    loads besides those that the robot states. Raises InputError."""
    path, n = Path(file), len(robot.joints)
    table = read_table(path, Layout(), pose_columns(robot), str(path))
    names = table.texts.get("payload", [])
    stated = [name for name in dict.fromkeys(names) if name in robot.payloads and name not in loads]
    loads = loads | {name: stated_load(robot.payloads[name]) for name in stated}
    rows = [row for row, name in enumerate(names) if name and name not in loads]
    what = [f"payload {names[row]!r} is not known" for row in rows]
    table.add_faults(rows, what, [f"say --payload {names[row]}=KG" for row in rows])
    for j, joint in enumerate(robot.joints, 1):
        if joint.kind == "revolute" and (name := f"q{j}") in table.numbers:
            many = np.abs(table.numbers[name]) > MOST_TURNED
            table.add_fault_where(many, name, "is many turns", f"are these degrees? then name it {name}_deg")
    if faults := [*table.faults, *check_poses(table, robot)]:
        raise InputError(faults)

    def columns(labels: Sequence[str]) -> Array | None:
        given = [table.numbers.get(label) for label in labels]
        zero = np.zeros(len(table))
        found = [zero if values is None else np.nan_to_num(values) for values in given]
        return None if all(values is None for values in given) else np.stack(found, axis=1)

    q, read = (columns([f"{one}{j + 1}" for j in range(n)]) for one in "qr")
    assert q is not None
    told = Told(
        q,
        names,
        wrench=columns(("fx", "fy", "fz", "mx", "my", "mz")),
        direction=columns([f"dir{j + 1}" for j in range(n)]),
        time=filled(table.numbers.get("t"), 0.0),
        temperature=filled(table.numbers.get("temp"), 0.0),
        readback=read,
        setup=table.texts.get("setup"),
        ids=tuple(table.texts.get("pose_id", ())),
    )
    return told, loads


def at_random(robot: Robot, count: int, rng: np.random.Generator) -> Told:
    """Random poses within the limits. Raises InputError."""
    if not 1 <= count <= MOST:
        raise InputError(Fault("--random", f"is {count}", f"give a number of poses, {MOST} at most"))
    return Told(random_poses(robot, count, rng))


def on_grid(robot: Robot, text: str) -> Told:
    """Joints from joint=from:to:count,... in deg or mm; those not named at 0. Raises InputError."""
    values, given = [np.zeros(1)] * len(robot.joints), set[str]()
    poses = 1
    for part in text.split(","):
        name, _, span = part.partition("=")
        if name not in robot.joint_names:
            raise InputError(Fault("--grid", f"no joint {name!r}", f"known: {', '.join(robot.joint_names)}"))
        if name in given:
            raise InputError(Fault("--grid", f"{name} is there twice", "give one range for each joint"))
        given.add(name)
        j = robot.joint_names.index(name)
        try:
            low, high, count = span.split(":")
            ends, number = (float(low), float(high)), int(count)
            if number < 1 or not np.isfinite(ends).all():
                raise ValueError
        except ValueError:
            raise InputError(
                Fault("--grid", f"{part!r} is no JOINT=FROM:TO:COUNT", "like joint_2=-60:20:9")
            ) from None
        poses *= number
        if poses > MOST:
            raise InputError(Fault("--grid", f"has more than {MOST} poses", "take a coarser grid"))
        unit = 1e-3 if robot.joints[j].kind == "prismatic" else np.pi / 180
        values[j] = unit * np.linspace(*ends, number)
    return Told(np.array(list(product(*values))))


def beyond_limits(robot: Robot, q: Array) -> list[str]:
    """A warning for each joint that poses (N, n) [rad, m] have beyond its limits."""
    counts = [int(np.count_nonzero(joint.beyond(at))) for joint, at in zip(robot.joints, q.T, strict=True)]
    return [
        f"beyond the limits of {joint.name} (at {count} of {len(q)} poses): are these its units?"
        for joint, count in zip(robot.joints, counts, strict=True)
        if count
    ]
