"""`workbench simulate`: a campaign in files from what the command line says."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from typing import TYPE_CHECKING

from ..files.faults import Fault, InputError
from .arguments import Commands, check_folder, json_option, not_negative, out_option, positive, seed_option
from .status import warn

if TYPE_CHECKING:
    import numpy as np

    from ..campaign import Campaign
    from ..campaign.payloads import Load
    from ..campaign.problem import Problem
    from ..effects.base import Effect
    from ..robot.description import Robot
    from ..robot.kinematics import Array
    from .told import Told

RECORDED = {"dir1": "--approach", "t_s": "--hours", "temp_degC": "--warm-degC"}  # columns and their options


def add(commands: Commands) -> None:
    parser = commands.add_parser(
        "simulate", help="a campaign from the Drake model, with chosen effects and noise"
    )
    parser.add_argument("robot", metavar="ROBOT", help="a name or the path of a robot TOML")
    poses = parser.add_mutually_exclusive_group(required=True)
    poses.add_argument("--poses", metavar="FILE", help="poses.csv with q1_deg ... as in a campaign")
    poses.add_argument("--random", type=int, metavar="N", help="N random poses within the limits")
    poses.add_argument(
        "--grid", metavar="JOINT=FROM:TO:COUNT,...", help="joints on a grid, deg or mm; others at 0"
    )
    parser.add_argument(
        "--effect",
        action="append",
        default=[],
        metavar="ID:key=value,...",
        help="what is hidden, as often as wanted; without numbers in its usual size",
    )
    parser.add_argument(
        "--payload",
        action="append",
        default=[],
        metavar="NAME=KG[:x,y,z mm]",
        help="measured with it besides without; NAME alone for one that a model.toml states",
    )
    parser.add_argument("--tool", metavar="KG[:x,y,z mm]", help="always mounted (default: the model's)")
    parser.add_argument(
        "--sigma-mm",
        type=not_negative("length"),
        default=0.03,
        metavar="MM",
        help="noise per axis, one sigma (0.03)",
    )
    parser.add_argument(
        "--geometry-mm",
        type=not_negative("length"),
        default=0.5,
        metavar="MM",
        help="random errors of lengths, one sigma (0.5)",
    )
    parser.add_argument(
        "--geometry-mrad",
        type=not_negative("angle", 1000.0),
        default=0.5,
        metavar="MRAD",
        help="random errors of angles, one sigma (0.5)",
    )
    parser.add_argument("--shots", type=positive, default=1, metavar="N", help="readings per standstill (1)")
    parser.add_argument("--approach", action="store_true", help="record random sides of approach (dir1 ...)")
    parser.add_argument(
        "--hours", type=not_negative("time"), default=0.0, metavar="H", help="record times over so many hours"
    )
    parser.add_argument(
        "--warm-degC",
        type=not_negative("rise of temperature", 200.0),
        default=0.0,
        metavar="K",
        help="record a warm-up from 20 °C by this much",
    )
    out_option(parser, "folder for campaign.toml and its tables (reports/simulated)", "reports/simulated")
    seed_option(parser, "poses, geometry, noise, sides and order")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    import numpy as np

    from ..campaign import write_campaign
    from ..campaign.problem import problem_of
    from ..effects.records import effect_text
    from ..robot.description import load_robot
    from ..simulation.virtual_campaign import Truth, idle_effects, random_geometry, simulate

    check_folder(arguments.out)
    robot = load_robot(arguments.robot)
    rng = np.random.default_rng([arguments.seed, 11])
    plan = _planned(arguments, robot, rng)
    problem = problem_of(plan)
    effects = _effects(arguments, problem)
    lengths, angles = 1e-3 * arguments.geometry_mm, 1e-3 * arguments.geometry_mrad
    truth = Truth(
        geometry=random_geometry(problem.arm, rng, lengths, angles),
        effects=effects,
        sigma=1e-3 * arguments.sigma_mm,
    )
    try:
        campaign = simulate(plan, truth, seed=arguments.seed, shots=arguments.shots)
    except InputError as error:
        raise InputError([_with_option(fault) for fault in error.faults]) from None
    for effect in idle_effects(plan, truth):
        said = "moves no point in these poses: it has nothing to act on (masses, payload, stiffness?)"
        warn(f"{effect.label} {said}")
    hidden = [f"simulated, seed {arguments.seed}", *(f"hidden: {effect_text(e, v)}" for e, v in effects)]
    write_campaign(arguments.out, campaign, comments=hidden)
    facts = {"robot": robot.name, "n_poses": len(campaign.poses.q), "folder": str(arguments.out)}
    said = f"{len(campaign.poses.q)} poses written to {arguments.out}/campaign.toml"
    print(json.dumps(facts) if arguments.json else said)


def _planned(arguments: argparse.Namespace, robot: Robot, rng: np.random.Generator) -> Campaign:
    """What is to be measured."""
    from ..campaign import payloads
    from ..campaign.planned import planned
    from ..robot.schema import stated_load
    from .told import beyond_limits

    poses, loads = _told(arguments, robot, rng)
    if robot.mounted and not arguments.tool:
        loads = loads | {robot.mounted: stated_load(robot.payloads[robot.mounted])}
        carried = poses.payload or [""] * len(poses.q)
        poses = replace(poses, payload=[name or robot.mounted for name in carried])
    plan = planned(
        robot,
        poses.q,
        payloads=loads,
        payload=poses.payload,
        tool=payloads.load(arguments.tool, "--tool") if arguments.tool else stated_load(robot.tool),
        wrench=poses.wrench,
        direction=poses.direction,
        time=poses.time,
        temperature=poses.temperature,
        readback=poses.readback,
        setup=poses.setup,
        title=f"{robot.title}, simulated, {len(poses.q)} poses",
    )
    for words in beyond_limits(robot, poses.q):
        warn(words)
    return plan.with_poses(ids=poses.ids) if poses.ids else plan


def _effects(arguments: argparse.Namespace, problem: Problem) -> tuple[tuple[Effect, Array], ...]:
    """What is hidden, with its values. Raises `InputError` for what cannot be."""
    from ..effects.records import check_possible, parse_effect

    effects = tuple(parse_effect(text, problem) for text in arguments.effect)
    for text, (effect, values) in zip(arguments.effect, effects, strict=True):
        check_possible(text, effect, values)
    return effects


def _with_option(fault: Fault) -> Fault:
    """The fault, with the option that would record the column that it misses."""
    option = next((option for column, option in RECORDED.items() if f"no column {column}" in fault.mend), "")
    return replace(fault, mend=f"{fault.mend} ({option})") if option else fault


def _told(
    arguments: argparse.Namespace, robot: Robot, rng: np.random.Generator
) -> tuple[Told, dict[str, Load]]:
    """What the robot is told, and the payloads by name."""
    from ..campaign import payloads
    from . import told

    loads = payloads.named_loads(arguments.payload, robot)
    if arguments.poses is not None:
        poses, loads = told.from_file(robot, arguments.poses, loads)
    elif arguments.grid is not None:
        poses = told.on_grid(robot, arguments.grid)
    else:
        poses = told.at_random(robot, arguments.random, rng)
    # poses of a file keep their order
    shuffled = None if arguments.poses is not None else rng
    poses = poses.with_and_without([*loads]).over(arguments.hours, shuffled).warming_up(arguments.warm_degC)
    return poses.approached(rng) if arguments.approach else poses, loads
