"""`workbench predict`."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..files.faults import Fault, InputError
from .arguments import (
    Commands,
    above_zero,
    check_folder,
    json_option,
    load_all,
    out_option,
    positive,
    seed_option,
    start_option,
    started,
    tool_option,
)
from .status import progress, warn

if TYPE_CHECKING:
    from ..campaign import Campaign
    from ..correction.paths import Path as ToolPath
    from ..robot.description import Robot

POSES = 2000  # drawn in the volume


def add(commands: Commands) -> None:
    parser = commands.add_parser("predict", help="error to be expected at the tool, with bounds")
    parser.add_argument("model", metavar="MODEL.toml", help="what diagnose wrote")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument(
        "--poses",
        metavar="FILE",
        help="a campaign.toml, whose poses and loads count; poses.csv in our own layout; or a path of joints "
        "or tool poses",
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
    tool_option(parser)
    start_option(parser)
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
        _without_tool_poses(arguments)
        rng, count = np.random.default_rng(arguments.seed), arguments.volume
        q = random_poses(robot, count, rng, share=1.0)
        if arguments.measured:
            q = rng.uniform(told.lower, told.upper, q.shape)
        errors, files = predict(robot, q, arguments.payload), dict[str, str]()
    else:
        campaign = _told(robot, arguments)
        errors, files = predict(robot, campaign), campaign.files
    tolerance = None if arguments.tolerance is None else 1e-3 * arguments.tolerance
    read = [*robot.files, *([] if arguments.poses is None else [Path(arguments.poses)])]
    expected = Expected(robot, errors, tolerance, files | digests(read))
    progress("writing the page, the table and the scene")
    write_expected(expected, out)
    for words in expected.beyond_limits:
        warn(words)
    print(json.dumps(expected.to_json()) if arguments.json else f"{expected.text}\n\nopen {out}/index.html")


def _without_tool_poses(arguments: argparse.Namespace) -> None:
    """Raises InputError for options that say what tool poses mean, where there are none."""
    given = {"--tool": arguments.tool, "--start": arguments.start}
    mend = "leave it out: nothing here is a pose of the tool"
    faults = [
        Fault(name, "goes with a path of tool poses", mend)
        for name, value in given.items()
        if value is not None
    ]
    if faults:
        raise InputError(faults)


def _measured(robot: Robot, arguments: argparse.Namespace) -> Campaign:
    """The campaign that `--poses` names, under its own loads. Raises InputError for another robot."""
    from ..campaign.same_robot import check_same_robot

    if arguments.payload:
        mend = "leave it out: the campaign says what the arm carries"
        raise InputError(Fault("--payload", "goes with poses that do not say theirs", mend))
    (campaign,) = load_all([arguments.poses])
    check_same_robot(robot, campaign)
    return campaign


def _path(file: Path, robot: Robot) -> ToolPath:
    """The path of a file. Raises InputError."""
    from ..correction.paths import load_path

    try:
        return load_path(file, robot)
    except InputError as error:
        other = ", or name the campaign.toml that says its columns"
        unknown = [one.what.startswith("has neither") for one in error.faults]
        faults = [
            replace(one, mend=one.mend + other * lacks)
            for one, lacks in zip(error.faults, unknown, strict=True)
        ]
        raise InputError(faults) from None


def _told(robot: Robot, arguments: argparse.Namespace) -> Campaign:
    """The poses of a file: a campaign's, joints as a campaign or a path has them, or poses of the tool."""
    from ..correction.solve import turning_sides
    from ..correction.trajectory import nominal_joints
    from ..files.faults import read_text
    from ..identification.prediction import posed
    from . import told

    file = Path(arguments.poses)
    if file.suffix == ".toml":
        _without_tool_poses(arguments)
        return _measured(robot, arguments)
    if "q1_" not in read_text(file).partition("\n")[0]:
        path = _path(file, robot)
        start = started(arguments.model, arguments.start)
        q = nominal_joints(robot, path, arguments.tool, start, arguments.seed)
        campaign = posed(robot, q, arguments.payload)
        wrench = campaign.poses.wrench if path.wrench is None else path.wrench
        side = turning_sides(q)
        return campaign.with_poses(wrench=wrench, side=side, temperature=path.temperature, time=path.time)
    _without_tool_poses(arguments)
    poses, _ = told.from_file(robot, arguments.poses, {})
    campaign = posed(robot, poses.q, poses.payload or arguments.payload)
    is_path = poses.time is not None and not poses.ids  # poses that are named are a list, in any order
    unsaid = turning_sides(poses.q) if is_path else None
    return campaign.with_poses(
        ids=poses.ids or campaign.poses.ids,
        wrench=campaign.poses.wrench if poses.wrench is None else poses.wrench,
        side=unsaid if poses.direction is None else poses.direction,
        time=poses.time,
        temperature=poses.temperature,
    )
