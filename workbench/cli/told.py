"""What a simulated robot is told: poses of a file, on a grid or at random, and what goes with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ..campaign.file import pose_columns
from ..campaign.payloads import Load
from ..campaign.planned import random_poses
from ..campaign.problem import REFERENCE_TEMPERATURE, filled
from ..files.faults import Fault, InputError
from ..files.tables import Layout, read_table
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.schema import stated_load


@dataclass(frozen=True)
class Told:
    """What the robot is told in N poses, as in `Campaign`; payload: (N,) names, empty while none are said;
    ids: (N) of a file that names its poses."""

    q: Array
    payload: Sequence[str] = ()
    wrench: Array | None = None
    direction: Array | None = None
    time: Array | None = None
    temperature: Array | None = None
    ids: tuple[str, ...] = ()

    def with_and_without(self, payloads: Sequence[str]) -> Told:
        """Every pose without and with each payload, unless a file said which."""
        if self.payload:
            return self
        copies = 1 + len(payloads)
        carried = [name for name in ["", *payloads] for _ in range(len(self.q))]
        tiled: dict[str, Any] = {
            name: np.concatenate([values] * copies)
            for name in ("wrench", "direction", "time", "temperature")
            if (values := getattr(self, name)) is not None
        }
        ids = self.ids if copies == 1 else ()
        return replace(self, q=np.tile(self.q, (copies, 1)), payload=carried, ids=ids, **tiled)

    def over(self, hours: float, shuffled: np.random.Generator | None) -> Told:
        """At even times, in random order if `shuffled`, unless a file said when."""
        if hours <= 0 or self.time is not None:
            return self
        order = np.arange(len(self.q)) if shuffled is None else shuffled.permutation(len(self.q))
        time = np.linspace(0, 3600 * hours, len(self.q))
        return replace(self, q=self.q[order], payload=[self.payload[i] for i in order], time=time)

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
    if table.faults:
        raise InputError(table.faults)

    def columns(labels: Sequence[str]) -> Array | None:
        given = [table.numbers.get(label) for label in labels]
        zero = np.zeros(len(table))
        found = [zero if values is None else np.nan_to_num(values) for values in given]
        return None if all(values is None for values in given) else np.stack(found, axis=1)

    q = columns([f"q{j + 1}" for j in range(n)])
    assert q is not None
    told = Told(
        q,
        names,
        wrench=columns(("fx", "fy", "fz", "mx", "my", "mz")),
        direction=columns([f"dir{j + 1}" for j in range(n)]),
        time=filled(table.numbers.get("t"), 0.0),
        temperature=filled(table.numbers.get("temp"), 0.0),
        ids=_unique(table.texts.get("pose_id", ())),
    )
    return told, loads


def _unique(ids: Sequence[str]) -> tuple[str, ...]:
    """The names of poses; none where they do not tell them apart."""
    return tuple(ids) if len({*ids}) == len(ids) and all(ids) else ()


def at_random(robot: Robot, count: int, rng: np.random.Generator) -> Told:
    """Random poses within the limits. Raises InputError."""
    if count < 1:
        raise InputError(Fault("--random", f"is {count}", "give a number of poses"))
    return Told(random_poses(robot, count, rng))


def on_grid(robot: Robot, text: str) -> Told:
    """Joints from joint=from:to:count,... in deg or mm; those not named at 0. Raises InputError."""
    values = [np.zeros(1)] * len(robot.joints)
    for part in text.split(","):
        name, _, span = part.partition("=")
        if name not in robot.joint_names:
            raise InputError(Fault("--grid", f"no joint {name!r}", f"known: {', '.join(robot.joint_names)}"))
        j = robot.joint_names.index(name)
        try:
            low, high, count = span.split(":")
            unit = 1e-3 if robot.joints[j].kind == "prismatic" else np.pi / 180
            values[j] = unit * np.linspace(float(low), float(high), int(count))
        except ValueError:
            raise InputError(
                Fault("--grid", f"{part!r} is no JOINT=FROM:TO:COUNT", "like joint_2=-60:20:9")
            ) from None
    return Told(np.array(list(product(*values))))
