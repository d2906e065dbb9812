"""`workbench plan`: a campaign or a robot in, the poses to measure next out."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..files.faults import Fault, InputError
from .arguments import (
    Commands,
    above_zero,
    check_folder,
    json_option,
    known_option,
    load_all,
    out_option,
    program_options,
    quick_option,
    seed_option,
)
from .status import progress, warn

if TYPE_CHECKING:
    from ..campaign import Campaign
    from ..measurement.design.next_poses import Plan
    from ..robot.description import Robot

HINT = (
    "At standstills joints keep to 90 % of their limits. Look at the scene before you drive, and drive "
    "slowly the first time: what is not in the URDF or in [[obstacles]] nobody has checked."
)
UNSEEN = (
    "Say where the instrument stands ([instrument] in the campaign or in --cell) to have its view checked."
)

UNPULLED = (
    "Planned without the external forces of the campaign: where they are to tell something, pull at each "
    "pose several ways and both ways, and write what pulled (fx_N ... mz_Nm), a row for each and one without."
)


def add(commands: Commands) -> None:
    parser = commands.add_parser(
        "plan", help="the next measurements: for accuracy, or to tell rival causes apart"
    )
    parser.add_argument(
        "source",
        nargs="+",
        metavar="CAMPAIGN.toml|ROBOT",
        help="what was measured already, one campaign or more; or a robot's name or TOML",
    )
    parser.add_argument("--poses", type=int, metavar="N", help="how many records (30)")
    parser.add_argument(
        "--minutes", type=above_zero("time"), metavar="M",
        help="instead of --poses: what brings most in this time, loads, stops and reflectors chosen too",
    )  # fmt: skip
    parser.add_argument(
        "--tell",
        metavar="CAUSE,CAUSE",
        help="two causes or more as in --effect: gear_ratio:joint=joint_2,link_mass:link=link_2, the first "
        "with its size where it was found; what is left out (joint, link, payload) is tried everywhere: "
        "gear_ratio,hose_torque; or the result.json of a diagnosis: all that it left open. What was found is "
        "settled in as few poses as do it; several of it at once are parted by semicolons",
    )
    known_option(parser)
    parser.add_argument(
        "--cell", type=Path, metavar="FILE",
        help="TOML with [instrument], [[obstacles]] and [driving] (default: those of the campaign)",
    )  # fmt: skip
    parser.add_argument(
        "--format", metavar="NAME",
        help="also a program that stands still at the poses: krl, rapid, val3, ls, urscript",
    )  # fmt: skip
    parser.add_argument(
        "--dwell", type=above_zero("time"), default=4.0, metavar="S",
        help="standstill at a pose with one reflector (4); each further one takes reflector_s of [driving]",
    )  # fmt: skip
    parser.add_argument(
        "--torque", action="store_true",
        help="also record the drives' torques: columns to fill in (always so where the campaign has them)",
    )  # fmt: skip
    parser.add_argument(
        "--payload",
        action="append",
        default=[],
        metavar="NAME=KG[:x,y,z mm]",
        help="a further load that can be mounted at the flange; NAME alone for one that a model.toml states",
    )
    parser.add_argument(
        "--reflector",
        action="append",
        default=[],
        metavar="LINK",
        help="a further target that can be put on a link, near its joint, or on the base",
    )
    out_option(
        parser,
        "folder for poses, campaign, page, scene and program; or a file for the poses or the program alone "
        "(reports/plan)",
    )
    program_options(parser)
    seed_option(parser, "the poses that are on offer")
    quick_option(parser, "fewer poses are on offer")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..campaign import Campaign
    from ..campaign.cell import read_cell
    from ..campaign.payloads import named_loads
    from ..correction.programs import find_format
    from ..correction.programs.measuring import check_format
    from ..measurement.design import plan

    poses, program = _places(arguments.out, arguments.format)
    check_folder(poses.parent)
    cell = None if arguments.cell is None else read_cell(arguments.cell)
    source = read_sources(arguments.source)
    robot = source.robot if isinstance(source, Campaign) else source
    if arguments.format:
        check_format(robot, find_format(arguments.format), arguments.as_urdf)
    made = plan(
        source,
        arguments.poses,
        tell=arguments.tell,
        known=arguments.known,
        seed=arguments.seed,
        quick=arguments.quick,
        minutes=arguments.minutes,
        cell=cell,
        dwell=arguments.dwell,
        torque=arguments.torque,
        payloads=named_loads(arguments.payload, robot),
        reflectors=arguments.reflector,
        progress=progress,
    )
    files = [] if made.drive is None else _write(source, made, poses, program, arguments)
    for one, other in [] if made.reach is None else made.reach.unchecked:
        warn(f"{one} and {other} touch in nearly all poses: whether they do is not checked")
    if arguments.json:
        print(json.dumps(_facts(source, made, poses, arguments) | {"files": [str(file) for file in files]}))
        return
    for fault in made.faults:
        print(f"Data fault: {fault.kind} at pose {fault.pose_id}: {fault.what} ({fault.done}).")
    print(made.text)
    if made.drive is None or made.reach is None:
        print("Nothing was written.")
        return
    print(f"{len(made.drive.records.poses)} standstills written to {poses}.")
    if isinstance(source, Campaign) and source.poses.wrench.any():
        print(UNPULLED)
    print(HINT if made.reach.sight is not None else f"{UNSEEN} {HINT}")
    for file in files[1:]:
        print(file)


def read_sources(texts: Sequence[str]) -> Campaign | Robot:
    """A robot, or a campaign, or several as one. Raises InputError."""
    from ..campaign import Campaign
    from ..campaign.joined import join

    found = [read_source(text) for text in texts]
    if len(found) == 1:
        return found[0]
    campaigns = [one for one in found if isinstance(one, Campaign)]
    if len(campaigns) < len(found):
        raise InputError(Fault(" ".join(texts), "are not campaigns only", "one robot, or campaigns"))
    return join(campaigns)


def read_source(text: str, *, tell: bool = True) -> Campaign | Robot:
    """A robot by its name or its TOML, which names a URDF; else a campaign, its warnings told. Raises
    InputError."""
    from ..campaign.load import campaign_file
    from ..files.toml import read_toml
    from ..robot.description import load_robot
    from ..robot.find import list_robots

    named = text in {path.stem for path in list_robots()}
    text = text if named else str(campaign_file(text))
    if Path(text).suffix in (".urdf", ".xacro"):
        raise InputError(Fault(text, "is not yet a robot", f"workbench init {text} makes one of it"))
    if not text.endswith(".toml"):
        if Path(text).exists() and not named:
            raise InputError(
                Fault(text, "is neither a TOML file nor a robot", "name campaign.toml or a robot")
            )
        return load_robot(text)
    if "urdf" in read_toml(Path(text)):
        return load_robot(text)
    (campaign,) = load_all([text], tell=tell)
    return campaign


def _places(out: Path | None, format: str | None) -> tuple[Path, Path]:
    """Where the poses go, and where the program goes: a file, or a folder."""
    from ..correction.programs import find_format
    from ..correction.programs.files import is_folder

    out = Path("reports/plan") if out is None else out
    if format and out.suffix.lower() != ".csv":
        chosen = find_format(format)
        folder = out if is_folder(out, chosen) else out.parent
        return folder / "poses.csv", out
    poses = out / "poses.csv" if is_folder(out, find_format("csv")) else out
    return poses, poses.parent


def _write(
    source: Campaign | Robot, made: Plan, poses: Path, program: Path, arguments: argparse.Namespace
) -> list[Path]:
    """The poses, beside them what goes into a folder, and the programs; nothing over other content silently.
    Raises InputError."""
    from ..campaign import Campaign
    from ..correction.programs import find_format
    from ..correction.programs.files import is_folder, program_files, put_files
    from ..measurement.driving.files import programs, table_files
    from ..measurement.driving.page import PlanPage, page_files

    assert made.drive is not None
    assert made.reach is not None
    keep, folder = not arguments.force, poses.parent
    whole = arguments.out is None or not arguments.out.suffix
    before = source.arguments if isinstance(source, Campaign) else ""
    files = table_files(made.drive, made.reach, folder, before)
    if not whole:
        files = {poses: files[folder / "poses.csv"]}
    if arguments.format:
        chosen = find_format(arguments.format)
        alone = is_folder(program, chosen)
        share = made.reach.cell.driving.speed_share
        stem = "measure" if alone else program.stem
        several = programs(made.drive, chosen, share, stem, arguments.as_urdf)
        for name, one in several.items():
            place = program if alone else program.with_stem(name)
            if chosen.own_folder and len(several) > 1:  # else the last would lie over the others
                place = (program if alone else program.parent) / name
            files |= program_files(one, chosen, place)
    pages = {}
    if whole:
        progress("drawing the scene")
        page = PlanPage(
            f"{made.reach.robot.title}: plan", made.headline, made.lines, made.gain, made.drive, made.reach,
            _facts(source, made, poses, arguments),
        )  # fmt: skip
        pages = {folder / name: data for name, data in page_files(page).items()}
    put_files(files, keep, pages)
    return [*files, *pages]


def _facts(source: Campaign | Robot, made: Plan, out: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    from ..campaign import Campaign
    from ..files.digest import digests

    read = source.files if isinstance(source, Campaign) else digests(source.files)
    told = arguments.tell if arguments.tell and arguments.tell.endswith(".json") else None
    beside = [Path(name) for name in (arguments.cell, told) if name]
    return {
        "robot": source.robot.name if isinstance(source, Campaign) else source.name,
        "campaign": str(source.path) if isinstance(source, Campaign) else None,
        **made.to_json(),
        "file": None if made.records is None else str(out),
        "inputs": {**read, **digests(beside)},
    }
