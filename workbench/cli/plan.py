"""`workbench plan`: a campaign or a robot in, the poses to measure next out."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..files.faults import Fault, InputError
from .arguments import Commands, json_option, load_all, out_option, quick_option, seed_option
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
        help="two causes as in --effect, without numbers: gear_ratio:joint=joint_2,link_mass:link=link_2; "
        "what is left out (joint, link, payload, variant) is tried everywhere: gear_ratio,hose_torque",
    )
    out_option(parser, "file for the poses (reports/plan/poses.csv)", "reports/plan/poses.csv")
    seed_option(parser, "the poses that are on offer")
    quick_option(parser, "fewer poses are on offer")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..measurement.design import plan

    out: Path = arguments.out
    if out.is_dir():
        raise InputError(Fault(str(out), "is a folder", "name a file with --out"))
    source = read_source(arguments.source)
    made = plan(
        source,
        arguments.poses,
        tell=arguments.tell,
        seed=arguments.seed,
        quick=arguments.quick,
        progress=progress,
    )
    if made.records is not None:
        write_poses(out, made.records)
    if arguments.json:
        print(json.dumps(_facts(source, made, out)))
        return
    for fault in made.faults:
        print(f"Data fault: {fault.kind} at pose {fault.pose_id}: {fault.what} ({fault.done}).")
    written = "Nothing was written." if made.records is None else f"{_written(made.records, out)}\n{HINT}"
    print(f"{made.text}\n{written}")


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


def write_poses(path: Path, records: Campaign) -> None:
    """poses.csv as `write_campaign` writes it, whole or not at all. Raises InputError."""
    from ..campaign.write import poses_text
    from ..files.whole import put

    try:
        put(path, poses_text(records))
    except OSError as error:
        raise InputError(
            Fault(str(path), error.strerror or "cannot be written", "name a file with --out")
        ) from None


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
