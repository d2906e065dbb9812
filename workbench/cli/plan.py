"""`workbench plan`: a campaign or a robot in, the poses to measure next out."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..files.faults import Fault, InputError
from .arguments import (
    Commands,
    json_option,
    known_option,
    load_all,
    out_option,
    program_options,
    quick_option,
    seed_option,
)
from .status import progress

if TYPE_CHECKING:
    from ..campaign import Campaign
    from ..measurement.design.next_poses import Plan
    from ..robot.description import Robot

HINT = (
    "Joints keep to 90 % of their limits and the arm above the floor; collisions and the instrument's view "
    "are for you to check."
)


def add(commands: Commands) -> None:
    parser = commands.add_parser(
        "plan", help="the next measurements: for accuracy, or to tell rival causes apart"
    )
    parser.add_argument(
        "source", metavar="CAMPAIGN.toml|ROBOT", help="what was measured already, or a robot's name or TOML"
    )
    parser.add_argument("--poses", type=int, default=30, metavar="N", help="how many records (30)")
    parser.add_argument(
        "--tell",
        metavar="CAUSE,CAUSE",
        help="two causes or more as in --effect, without numbers: "
        "gear_ratio:joint=joint_2,link_mass:link=link_2; "
        "what is left out (joint, link, payload, variant) is tried everywhere: gear_ratio,hose_torque",
    )
    known_option(parser)
    parser.add_argument(
        "--format", metavar="NAME",
        help="also a program that stands still at the poses: krl, rapid, val3, ls, urscript",
    )  # fmt: skip
    parser.add_argument(
        "--dwell", type=float, default=4.0, metavar="S", help="standstill of that program at a pose (4)"
    )
    out_option(
        parser, "file for the poses, or for the program with the poses beside it, or a folder (reports/plan)"
    )
    program_options(parser)
    seed_option(parser, "the poses that are on offer")
    quick_option(parser, "fewer poses are on offer")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..measurement.design import plan

    poses, program = _places(arguments.out, arguments.format)
    source = read_source(arguments.source)
    made = plan(
        source,
        arguments.poses,
        tell=arguments.tell,
        known=arguments.known,
        seed=arguments.seed,
        quick=arguments.quick,
        progress=progress,
    )
    files: list[Path] = []
    if made.records is not None:
        files = write_poses(poses, made.records, not arguments.force)
        if arguments.format:
            files += write_programs(program, made.records, arguments)
    if arguments.json:
        print(json.dumps(_facts(source, made, poses) | {"files": [str(file) for file in files]}))
        return
    for fault in made.faults:
        print(f"Data fault: {fault.kind} at pose {fault.pose_id}: {fault.what} ({fault.done}).")
    written = "Nothing was written." if made.records is None else f"{_written(made.records, poses)}\n{HINT}"
    programs = "".join(f"\n{file}" for file in files[1:])
    print(f"{made.text}\n{written}{programs}")


def read_source(text: str) -> Campaign | Robot:
    """A robot by its name or its TOML, which names a URDF; else a campaign. Raises InputError."""
    from ..files.toml import read_toml
    from ..robot.description import load_robot
    from ..robot.find import list_robots

    if Path(text).suffix in (".urdf", ".xacro"):
        raise InputError(Fault(text, "is not yet a robot", f"workbench init {text} makes one of it"))
    if not text.endswith(".toml"):
        if Path(text).exists() and text not in {path.stem for path in list_robots()}:
            raise InputError(
                Fault(text, "is neither a TOML file nor a robot", "name campaign.toml or a robot")
            )
        return load_robot(text)
    if "urdf" in read_toml(Path(text)):
        return load_robot(text)
    (campaign,) = load_all([text])
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


def write_poses(path: Path, records: Campaign, keep: bool) -> list[Path]:
    """poses.csv as `write_campaign` writes it, whole or not at all. Raises InputError."""
    from ..campaign.write import poses_text
    from ..correction.programs.files import put_files

    put_files({path: poses_text(records).encode()}, keep)
    return [path]


def write_programs(out: Path, records: Campaign, arguments: argparse.Namespace) -> list[Path]:
    """A measuring program for each payload, in the order of the poses. Raises InputError."""
    from ..correction.conditions import carried, conditions_of
    from ..correction.programs import find_format, measuring_program, write_program
    from ..correction.programs.files import is_folder

    chosen, poses, files = find_format(arguments.format), records.poses, []
    stem = "measure" if is_folder(out, chosen) else out.stem
    for k, payload in enumerate(records.payload_names):
        rows = poses.payload == k
        if not rows.any():
            continue
        name = f"{stem}_{payload}" if payload else stem
        place = out if is_folder(out, chosen) else out.with_stem(name)
        program = measuring_program(
            records.robot,
            poses.q[rows],
            chosen,
            arguments.dwell,
            sides=None if poses.side is None else poses.side[rows],
            name=name,
            load=carried(conditions_of(records, payload)),
            as_urdf=arguments.as_urdf,
        )
        files += write_program(program, chosen, place, not arguments.force)
    return files


def _facts(source: Campaign | Robot, made: Plan, out: Path) -> dict[str, Any]:
    from ..campaign import Campaign

    return {
        "robot": source.robot.name if isinstance(source, Campaign) else source.name,
        "campaign": str(source.path) if isinstance(source, Campaign) else None,
        **made.to_json(),
        "file": None if made.records is None else str(out),
    }


def _written(records: Campaign, out: Path) -> str:
    from ..measurement.design.candidates import payload_counts

    loads = [
        f"{count} with {name or 'no payload'}" for name, count in payload_counts(records).items() if count
    ]
    carried = f" ({', '.join(loads)})" if len(records.payload_names) > 1 else ""
    steps = "" if records.poses.time is None else "session by session, "
    steps += "load by load, " if len(loads) > 1 else ""
    count = len(records.poses)
    return f"{count} poses{carried} written to {out}: {steps}from each to the nearest that is left."
