"""`workbench plan`: a campaign or a robot in, the poses to measure next out."""

from __future__ import annotations

import argparse
import json
import tempfile
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...arguments import load_all
from ...campaign import Campaign, write_campaign
from ...files.faults import Fault, InputError, read_text
from ...files.whole import put
from ...robot.description import Robot, list_robots, load_robot
from .accuracy import AccuracyPlan, plan_accuracy
from .candidates import payload_counts
from .knowledge import measured, unmeasured
from .tell import TellPlan, plan_tell

POOL = 1200  # candidate records
QUICK_POOL = 400
STARTS = 3  # of the exchange
HINT = (
    "Joints keep to 90 % of their limits and the arm above the floor; collisions and the instrument's view "
    "are for you to check."
)

Plan = AccuracyPlan | TellPlan
Progress = Callable[[str], None]


def plan(
    source: Campaign | Robot,
    poses: int = 30,
    *,
    tell: str | None = None,
    seed: int = 0,
    quick: bool = False,
    progress: Progress = lambda _: None,
) -> Plan:
    """The next poses to measure: for accuracy, or (`tell`: two causes, "A,B", each as in `--effect`) to tell
    rival causes apart. What a campaign has shown already counts. Raises InputError where there is no plan."""
    if poses < 1:
        raise InputError(Fault("--poses", f"is {poses}", "give a number of poses"))
    progress("fitting the campaign" if isinstance(source, Campaign) else "loading the robot")
    known = measured(source) if isinstance(source, Campaign) else unmeasured(source)
    pool, starts = (max(QUICK_POOL, 2 * poses), 1) if quick else (max(POOL, 4 * poses), STARTS)
    progress(f"choosing {poses} of about {pool} possible records")
    made: Plan
    if tell is not None:
        made = plan_tell(known, tell, poses, pool, starts, seed)
    else:
        made = plan_accuracy(known, poses, pool, starts, seed)
    return replace(made, faults=known.faults)


def plan_command(arguments: argparse.Namespace, progress: Progress) -> str:
    """Plans what the arguments say, writes the poses, and returns what to print. Raises InputError."""
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
        return json.dumps(_facts(source, made, out))
    faults = [f"Data fault: {f.kind} at pose {f.pose_id}: {f.what} ({f.done})." for f in made.faults]
    written = ["Nothing was written."] if made.records is None else [_written(made.records, out), HINT]
    return "\n".join([*faults, made.text, *written])


def _facts(source: Campaign | Robot, made: Plan, out: Path) -> dict[str, Any]:
    return {
        "robot": source.robot.name if isinstance(source, Campaign) else source.name,
        "campaign": str(source.path) if isinstance(source, Campaign) else None,
        **made.to_json(),
        "file": None if made.records is None else str(out),
    }


def read_source(text: str) -> Campaign | Robot:
    """A robot by its name or its TOML, which names a URDF; else a campaign."""
    if not text.endswith(".toml"):
        if Path(text).exists() and text not in {path.stem for path in list_robots()}:
            raise InputError(
                Fault(text, "is neither a TOML file nor a robot", "name campaign.toml or a robot")
            )
        return load_robot(text)
    try:
        content = tomllib.loads(read_text(Path(text)))
    except tomllib.TOMLDecodeError as error:
        raise InputError(Fault(text, f"is not TOML: {error}")) from None
    if "urdf" in content:
        return load_robot(text)
    (campaign,) = load_all([text])
    return campaign


def write_poses(path: Path, records: Campaign) -> None:
    """poses.csv of the contract, as `write_campaign` writes it, whole or not at all. Raises InputError."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            write_campaign(folder, records)
            put(path, (Path(folder) / "poses.csv").read_bytes())
    except OSError as error:
        raise InputError(
            Fault(str(path), error.strerror or "cannot be written", "name a file with --out")
        ) from None


def _written(records: Campaign, out: Path) -> str:
    loads = [
        f"{count} with {name or 'no payload'}" for name, count in payload_counts(records).items() if count
    ]
    carried = f" ({', '.join(loads)})" if len(records.payload_names) > 1 else ""
    steps = "" if records.time is None else "session by session, "
    steps += "load by load, " if len(loads) > 1 else ""
    return f"{len(records.q)} poses{carried} written to {out}: {steps}from each to the nearest that is left."
