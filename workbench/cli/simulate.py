"""`workbench simulate`: what the command line says, as a plan, a truth and a campaign in files."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from ..campaign import Campaign, write_campaign
from ..campaign.file import pose_columns
from ..campaign.planned import planned, random_poses
from ..campaign.problem import filled, problem
from ..effects.records import effect_text, parse_effect
from ..files.faults import Fault, InputError
from ..files.tables import Layout, read_table
from ..robot.description import Robot, load_robot
from ..robot.kinematics import Array
from ..robot.schema import stated_load
from ..simulation.virtual_campaign import Truth, random_geometry, simulate

Load = tuple[float, tuple[float, float, float]]


@dataclass(frozen=True)
class _Told:
    """What the robot is told in N poses; as in `Campaign`, payloads by name."""

    q: Array
    payload: list[str]
    wrench: Array | None = None
    direction: Array | None = None
    time: Array | None = None
    temperature: Array | None = None


def simulate_command(arguments: argparse.Namespace) -> Campaign:
    """Simulates what the arguments say and writes the campaign. Raises InputError."""
    robot = load_robot(arguments.robot)
    rng = np.random.default_rng([arguments.seed, 11])
    loads = dict(_payload(text, robot) for text in arguments.payload)
    told = _file(robot, arguments.poses, loads) if arguments.poses else _drawn(robot, arguments, rng)
    told = _drawn_besides(told, arguments, loads, rng)
    plan = planned(
        robot,
        told.q,
        payloads=loads,
        payload=told.payload,
        tool=_load(arguments.tool, "--tool") if arguments.tool else stated_load(robot.tool),
        wrench=told.wrench,
        direction=told.direction,
        time=told.time,
        temperature=told.temperature,
        title=f"{robot.title}, simulated, {len(told.q)} poses",
    )
    job = problem(plan)
    effects = tuple(parse_effect(text, job) for text in arguments.effect)
    truth = Truth(
        geometry=random_geometry(job.arm, rng, 1e-3 * arguments.geometry_mm, 1e-3 * arguments.geometry_mrad),
        effects=effects,
        sigma=1e-3 * arguments.sigma_mm,
    )
    campaign = simulate(plan, truth, seed=arguments.seed, shots=arguments.shots)
    hidden = [f"simulated, seed {arguments.seed}", *(f"hidden: {effect_text(e, v)}" for e, v in effects)]
    write_campaign(arguments.out, campaign, comments=hidden)
    return campaign


def _file(robot: Robot, file: str, loads: dict[str, Load]) -> _Told:
    """The poses of a file, with the payloads, wrenches, sides, times and temperatures that it gives."""
    path, n = Path(file), len(robot.joints)
    table = read_table(path, Layout(), pose_columns(robot), str(path))
    names = table.texts.get("payload", [])
    for name in dict.fromkeys(names):
        if name and name not in loads and name in robot.payloads:
            loads[name] = stated_load(robot.payloads[name])
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
    return _Told(
        q,
        list(names),
        columns(("fx", "fy", "fz", "mx", "my", "mz")),
        columns([f"dir{j + 1}" for j in range(n)]),
        filled(table.numbers.get("t"), 0.0),
        filled(table.numbers.get("temp"), 0.0),
    )


def _drawn(robot: Robot, arguments: argparse.Namespace, rng: np.random.Generator) -> _Told:
    """Random poses or a grid."""
    if arguments.random is None:
        return _Told(_grid(robot, arguments.grid), [])
    if arguments.random < 1:
        raise InputError(Fault("--random", f"is {arguments.random}", "give a number of poses"))
    return _Told(random_poses(robot, arguments.random, rng), [])


def _drawn_besides(
    told: _Told, arguments: argparse.Namespace, loads: dict[str, Load], rng: np.random.Generator
) -> _Told:
    """Each pose without and with every payload, unless a file says; then times and sides as asked.

    Drawn poses come in random order where time counts, those of a file in its own."""
    if not told.payload:
        copies = 1 + len(loads)
        told = replace(
            told,
            q=np.tile(told.q, (copies, 1)),
            payload=[name for name in ["", *loads] for _ in range(len(told.q))],
            **{
                name: np.concatenate([values] * copies)
                for name in ("wrench", "direction", "time", "temperature")
                if (values := getattr(told, name)) is not None
            },
        )
    if arguments.hours > 0 and told.time is None:
        order = np.arange(len(told.q)) if arguments.poses else rng.permutation(len(told.q))
        told = replace(told, q=told.q[order], payload=[told.payload[i] for i in order])
        told = replace(told, time=np.linspace(0, 3600 * arguments.hours, len(told.q)))
    if arguments.warm_degC and told.temperature is None:
        share = np.linspace(0, 1, len(told.q)) if told.time is None else told.time / told.time.max()
        rise = (1 - np.exp(-3 * share)) / (1 - np.exp(-3))
        told = replace(told, temperature=20 + arguments.warm_degC * rise)
    if arguments.approach and told.direction is None:
        told = replace(told, direction=rng.choice([-1.0, 1.0], size=told.q.shape))
    return told


def _grid(robot: Robot, text: str) -> Array:
    """Joints (N, n) from joint=from:to:count,... in deg or mm."""
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
    return np.array(list(product(*values)))


def _payload(text: str, robot: Robot) -> tuple[str, Load]:
    """Name and load; the name alone for a payload that the robot's own TOML states."""
    name, equals, rest = text.partition("=")
    if name in robot.payloads and not equals:
        return name, stated_load(robot.payloads[name])
    if not equals or not name:
        raise InputError(Fault("--payload", f"{text!r} is no NAME=KG", "like heavy=250:150,0,0"))
    return name, _load(rest, "--payload")


def _load(text: str, place: str) -> Load:
    mass, _, com = text.partition(":")
    try:
        x, y, z = (float(v) * 1e-3 for v in com.split(",")) if com else (0.0, 0.0, 0.0)
        load = float(mass), (x, y, z)
        if not (0 <= load[0] < math.inf and all(map(math.isfinite, load[1]))):
            raise ValueError
    except ValueError:
        raise InputError(Fault(place, f"{text!r} is no KG:x,y,z (mm)", "like 250:150,0,0")) from None
    return load
