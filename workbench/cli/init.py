"""`workbench init`."""

from __future__ import annotations

import argparse
import json
import math
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from ..files.faults import Fault, InputError
from .arguments import Commands, check_folder, json_option, out_option
from .status import progress, warn

if TYPE_CHECKING:
    from ..campaign.guess import Misfit
    from ..robot.chain import MovingJoint
    from ..robot.kinematics import Arm
    from ..robot.new_robot import NewRobot


def add(commands: Commands) -> None:
    parser = commands.add_parser("init", help="a folder for your own robot, from its URDF or xacro")
    parser.add_argument("urdf", metavar="URDF", help="a URDF or xacro file, as published")
    parser.add_argument("arguments", nargs="*", metavar="NAME:=VALUE", help="arguments of the xacro file")
    parser.add_argument("--flange", metavar="LINK", help="carries tool and targets (default: guessed)")
    parser.add_argument("--base", metavar="LINK", help="where the arm begins (default: the root)")
    parser.add_argument("--name", dest="robot", metavar="NAME", help="of the robot (default: the file's)")
    parser.add_argument(
        "--package",
        action="append",
        default=[],
        metavar="NAME=DIR",
        help="where package://NAME is (besides the folders around the file and ROS's own paths)",
    )
    parser.add_argument("--poses", type=Path, metavar="FILE", help="your table of joints, its layout guessed")
    parser.add_argument("--points", type=Path, metavar="FILE", help="your instrument's table, likewise")
    out_option(parser, "folder for robot, campaign template and README (default: the robot's name)")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..campaign.template import LACKING, template_files
    from ..files.whole import put_all
    from ..robot.new_robot import new_robot
    from ..robot.packages import given_packages

    words = [text.partition(":=") for text in arguments.arguments]
    if bad := [name for name, sign, _ in words if not sign]:
        raise InputError(
            Fault(bad[0], "is no NAME:=VALUE", "one URDF at a time; xacro arguments like ur_type:=ur10e")
        )
    check_folder(arguments.out)
    made = new_robot(
        Path(arguments.urdf),
        arguments.flange,
        arguments.base,
        arguments.robot,
        {name: value for name, _, value in words},
        given_packages(arguments.package),
    )
    folder: Path = arguments.out or Path(made.name)
    template = template_files(made, folder, arguments.poses, arguments.points, _misfit(made))
    files = {**made.files, **template}
    there = [folder / path for path in files if (folder / path).exists()]
    if there:
        raise InputError(Fault(str(there[0]), "is there already", "name another folder with --out"))
    put_all({folder / path: data for path, data in files.items()})
    for note in made.notes:
        progress(note)
    for line in template[Path("campaign.toml")].splitlines():
        if line.startswith(LACKING):
            warn(f"{folder / 'campaign.toml'}: {line.removeprefix('# ')}")
    measured = arguments.poses is not None and arguments.points is not None
    print(json.dumps(_facts(made, folder)) if arguments.json else _text(made, folder, measured))


def _misfit(made: NewRobot) -> Misfit:
    """How far points are off the robot as its URDF says, in the best place of the instrument; the robot is
    read where it is asked for."""
    from ..files.whole import put_all
    from ..identification.registration import off_the_arm
    from ..robot.description import load_robot
    from ..robot.rigid_plant import arrays

    @cache
    def arm() -> Arm:
        with tempfile.TemporaryDirectory(prefix="workbench-") as scratch:
            put_all({Path(scratch) / path: data for path, data in made.files.items()})
            return arrays(load_robot(Path(scratch) / f"{made.name}.toml"))

    return lambda q, points: off_the_arm(arm(), q, points)


def _facts(made: NewRobot, folder: Path) -> dict[str, object]:
    return {
        "robot": str(folder / f"{made.name}.toml"),
        "campaign": str(folder / "campaign.toml"),
        "base": made.chain.base,
        "flange": {"link": made.flange.flange, "why": made.flange.why},
        "joints": [
            {"name": j.name, "kind": j.kind, "lower": j.lower, "upper": j.upper} for j in made.chain.joints
        ],
        "notes": list(made.notes),
    }


def _text(made: NewRobot, folder: Path, measured: bool) -> str:
    """What was made, and what to do next. measured: both tables were given."""
    guessed = "" if made.flange.why == "as said" else f" (guessed: {made.flange.why}; --flange says another)"
    joints = made.chain.joints
    many = f"{len(joints)} joints" if len(joints) > 1 else "1 joint"
    lines = [f"{made.name}: {many} from {made.chain.base} to {made.flange.flange}{guessed}"]
    lines += [
        f"  {i}  {joint.name:<24} {joint.link:<20} {_range(joint)}" for i, joint in enumerate(joints, 1)
    ]
    campaign, next_ = ("campaign", "campaign") if measured else ("campaign template", made.name)
    lines += [
        f"Written to {folder}: robot, {campaign}, README.md with the next steps.",
        f"Next: workbench check {folder / next_}.toml",
    ]
    return "\n".join(lines)


def _range(joint: MovingJoint) -> str:
    kind, lower, upper = joint.kind, joint.lower, joint.upper
    if not math.isfinite(upper - lower):
        return f"{kind}, no limits"
    unit, factor = ("°", 180 / math.pi) if kind == "revolute" else (" mm", 1e3)
    return f"{kind}, {factor * lower:.0f} .. {factor * upper:.0f}{unit}"
