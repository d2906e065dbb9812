"""`workbench predict`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from ..files.faults import Fault, InputError
from .arguments import Commands, above_zero, check_folder, json_option, out_option, positive, seed_option
from .status import progress, warn

if TYPE_CHECKING:
    from ..campaign import Campaign
    from ..robot.description import Robot

POSES = 2000  # drawn in the volume


def add(commands: Commands) -> None:
    parser = commands.add_parser("predict", help="error to be expected at the tool, with bounds")
    parser.add_argument("model", metavar="MODEL.toml", help="what diagnose wrote")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument(
        "--poses", metavar="FILE", help="poses.csv as in a campaign, or a path of joints or tool poses"
    )
    where.add_argument(
        "--volume",
        nargs="?",
        type=positive,
        const=POSES,
        metavar="N",
        help=f"N random poses within the joints' limits ({POSES})",
    )
    parser.add_argument(
        "--measured", action="store_true",
        help="with --volume: within the range in which each joint was measured, not within its limits",
    )  # fmt: skip
    parser.add_argument(
        "--payload", default="", metavar="NAME", help="what the arm carries, where the file says nothing"
    )
    parser.add_argument(
        "--tolerance",
        type=above_zero("length"),
        metavar="MM",
        help="at how many poses the tool stays inside this",
    )
    out_option(
        parser,
        "folder for the page, the scene, the table and the numbers (reports/predict)",
        "reports/predict",
    )
    seed_option(parser, "the poses of the volume, and of the postures tried for a path's first pose")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    import numpy as np

    from ..campaign.planned import random_poses
    from ..files.digest import digests
    from ..identification.prediction import predict, required_uncertainty
    from ..report.expectation import Expected, write_expected
    from ..robot.description import load_robot

    out: Path = arguments.out
    check_folder(out)
    robot = load_robot(arguments.model)
    told = required_uncertainty(robot)
    if arguments.measured and arguments.volume is None:
        raise InputError(Fault("--measured", "goes with --volume", "leave it out: the file says the poses"))
    if arguments.volume is not None:
        rng, count = np.random.default_rng(arguments.seed), arguments.volume
        q = random_poses(robot, count, rng, share=1.0)
        if arguments.measured:
            q = rng.uniform(told.lower, told.upper, q.shape)
        errors = predict(robot, q, arguments.payload)
    else:
        errors = predict(robot, _told(robot, arguments))
    tolerance = None if arguments.tolerance is None else 1e-3 * arguments.tolerance
    read = [*robot.files, *([] if arguments.poses is None else [Path(arguments.poses)])]
    expected = Expected(robot, errors, tolerance, digests(read))
    progress("writing the page, the table and the scene")
    write_expected(expected, out)
    for words in expected.beyond_limits:
        warn(words)
    print(json.dumps(expected.to_json()) if arguments.json else f"{expected.text}\n\nopen {out}/index.html")


def _told(robot: Robot, arguments: argparse.Namespace) -> Campaign:
    """The poses of a file: joints as a campaign or a path has them, or tool poses of the flange."""
    from ..correction import nominal_joints
    from ..correction.paths import load_path
    from ..files.faults import read_text
    from ..identification.prediction import posed
    from . import told

    file = Path(arguments.poses)
    if "q1_" not in read_text(file).partition("\n")[0]:
        path = load_path(file, robot)
        campaign = posed(robot, nominal_joints(robot, path, seed=arguments.seed), arguments.payload)
        wrench = campaign.poses.wrench if path.wrench is None else path.wrench
        return campaign.with_poses(wrench=wrench, temperature=path.temperature, time=path.time)
    poses, _ = told.from_file(robot, arguments.poses, {})
    campaign = posed(robot, poses.q, poses.payload or arguments.payload)
    return campaign.with_poses(
        ids=poses.ids or campaign.poses.ids,
        wrench=campaign.poses.wrench if poses.wrench is None else poses.wrench,
        side=poses.direction,
        time=poses.time,
        temperature=poses.temperature,
    )
