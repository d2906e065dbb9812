"""`workbench simulate`: what the command line says, as a plan, a truth and a campaign in files."""

from __future__ import annotations

import argparse
import math
from itertools import product
from pathlib import Path

import numpy as np

from .arm import Array
from .campaign import Campaign, write_campaign
from .campaign.file import pose_columns
from .faults import Fault, InputError
from .poses import planned, random_poses
from .problem import problem
from .records import effect_text, parse_effect
from .robot import LoadData, Robot, load_robot
from .simulate import Truth, random_geometry, simulate
from .tables import Layout, read_table

Load = tuple[float, tuple[float, float, float]]


def simulate_command(arguments: argparse.Namespace) -> Campaign:
    """Simulates what the arguments say and writes the campaign. Raises InputError."""
    robot = load_robot(arguments.robot)
    rng = np.random.default_rng([arguments.seed, 11])
    q = _poses(robot, arguments, rng)
    loads = dict(_payload(text, robot) for text in arguments.payload)
    payload = [name for name in ["", *loads] for _ in range(len(q))]
    q = np.tile(q, (1 + len(loads), 1))
    order = rng.permutation(len(q)) if arguments.hours > 0 else np.arange(len(q))
    q, payload = q[order], [payload[i] for i in order]
    time = np.linspace(0, 3600 * arguments.hours, len(q)) if arguments.hours > 0 else None
    temperature = None
    if arguments.warm_degC:
        share = np.linspace(0, 1, len(q)) if time is None else time / time.max()
        temperature = 20 + arguments.warm_degC * (1 - np.exp(-3 * share)) / (1 - np.exp(-3))
    direction = rng.choice([-1.0, 1.0], size=q.shape) if arguments.approach else None
    plan = planned(
        robot,
        q,
        payloads=loads,
        payload=payload,
        tool=_load(arguments.tool, "--tool") if arguments.tool else _stated(robot.tool),
        direction=direction,
        time=time,
        temperature=temperature,
        title=f"{robot.title}, simulated, {len(q)} poses",
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


def _poses(robot: Robot, arguments: argparse.Namespace, rng: np.random.Generator) -> Array:
    if arguments.poses:
        path = Path(arguments.poses)
        table = read_table(path, Layout(), pose_columns(robot), str(path))
        if table.faults:
            raise InputError(table.faults)
        return np.column_stack([table.numbers[f"q{j + 1}"] for j in range(len(robot.joints))])
    if arguments.random is not None:
        if arguments.random < 1:
            raise InputError(Fault("--random", f"is {arguments.random}", "give a number of poses"))
        return random_poses(robot, arguments.random, rng)
    return _grid(robot, arguments.grid)


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
        return name, _stated(robot.payloads[name])
    if not equals or not name:
        raise InputError(Fault("--payload", f"{text!r} is no NAME=KG", "like heavy=250:150,0,0"))
    return name, _load(rest, "--payload")


def _stated(load: LoadData | None) -> Load:
    if load is None:
        return 0.0, (0.0, 0.0, 0.0)
    x, y, z = load.com_mm
    return load.mass_kg, (1e-3 * x, 1e-3 * y, 1e-3 * z)


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
