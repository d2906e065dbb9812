"""Options that several commands have, and what they mean: campaigns, loads, folders."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from ..files.faults import Fault, InputError
from .status import progress, warn

if TYPE_CHECKING:
    from ..campaign import Campaign
    from ..correction.conditions import Conditions
    from ..robot.kinematics import Array

MOST = 1_000_000  # of what can be counted; mm and other units of a number, more is a slip

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def out_option(parser: argparse.ArgumentParser, what: str, default: str | None = None) -> None:
    """`--out`; what: file or folder, and what is written there where nothing is said."""
    path = Path(default) if default else None
    parser.add_argument("--out", type=_place, default=path, metavar="PATH", help=what)


def _place(text: str) -> Path:
    """A path that was said: "" would be the current folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError("is empty: name a file or folder")
    return Path(text)


def json_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--json", action="store_true", help="the result to standard output, nothing else there"
    )


def seed_option(parser: argparse.ArgumentParser, of: str, default: int = 0) -> None:
    """`--seed`; of: what is drawn at random."""
    parser.add_argument("--seed", type=from_zero, default=default, metavar="N", help=f"of {of} ({default})")


def quick_option(parser: argparse.ArgumentParser, how: str) -> None:
    parser.add_argument("--quick", action="store_true", help=f"faster: {how}")


def workers_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--workers", type=positive, metavar="N", help="processes (default: all cores)")


def known_option(parser: argparse.ArgumentParser) -> None:
    """`--known`: facts beside the `[known]` of the campaign."""
    parser.add_argument(
        "--known", action="append", default=[], metavar="FACT",
        help="known by other means, repeated for more: link_mass:link=link_2,mass_kg=311,std=2, or "
        '"no hose_torque", "no backlash(joint_5)"',
    )  # fmt: skip


def load_options(parser: argparse.ArgumentParser, besides: str = "") -> None:
    """Tool and payload along a path; `conditions` says what they mean. besides: what else of a campaign
    counts."""
    parser.add_argument(
        "--payload", default="", metavar="NAME", help="what the arm carries (default: nothing)"
    )
    parser.add_argument(
        "--campaign",
        metavar="CAMPAIGN.toml",
        help=f"where tool and payload are stated (default: the model){besides}",
    )


def tool_option(parser: argparse.ArgumentParser) -> None:
    """`--tool` of a path; `frames_option` is a program's."""
    parser.add_argument(
        "--tool", type=frame, metavar="X,Y,Z,A,B,C",
        help="tool in the flange frame, whose poses a path of tool poses gives: mm, deg, "
        "R = Rz(a) Ry(b) Rx(c)",
    )  # fmt: skip


def frames_option(parser: argparse.ArgumentParser, name: str, what: str) -> None:
    """`--name` with a frame, or with a program's several by their names. `frames_given` reads it, and for
    paths `only_frame`."""
    parser.add_argument(
        f"--{name}", type=named_frame, action="append", default=[], metavar="[NAME=]X,Y,Z,A,B,C",
        help=f"{what}: mm, deg, R = Rz(a) Ry(b) Rx(c); of several that a program has on the controller each "
        "by its name there",
    )  # fmt: skip


def start_option(parser: argparse.ArgumentParser) -> None:
    """`--start`; `started` reads it."""
    parser.add_argument(
        "--start", type=numbers, metavar="Q1,Q2,...",
        help="posture at the first tool pose, where the file does not say it: joints near there as the URDF "
        "counts them, deg, sliding ones mm (default: what stays farthest from the limits)",
    )  # fmt: skip


def program_options(parser: argparse.ArgumentParser) -> None:
    """How a robot program is written."""
    parser.add_argument(
        "--as-urdf", action="store_true",
        help="joints and frames as the URDF has them, where the robot's TOML has no [controller]",
    )  # fmt: skip
    parser.add_argument("--force", action="store_true", help="replace files that are there already")


def frame(text: str) -> Array:
    """(4, 4) of x,y,z or x,y,z,a,b,c: mm and degrees, R = Rz(a) Ry(b) Rx(c)."""
    import numpy as np

    from ..robot.rotations import from_zyx, pose

    told = _listed(text)
    if len(told) not in (3, 6):
        raise argparse.ArgumentTypeError(f"{text!r} is no x,y,z or x,y,z,a,b,c (mm, deg)")
    if max(map(abs, told[:3])) > MOST:
        raise argparse.ArgumentTypeError(f"{text!r} is more than 1 km away (mm, deg)")
    turn = np.radians([(told + [0.0] * 3)[3:6]])
    return pose(1e-3 * np.array(told[:3]), from_zyx(turn)[0])


def named_frame(text: str) -> tuple[str, Array]:
    """A frame and the name before it; without one an empty name."""
    name, _, told = text.rpartition("=")
    return name.strip(), frame(told)


def frames_given(name: str, given: Sequence[tuple[str, Array]]) -> dict[str, Array]:
    """(4, 4) the frames that `--name` gives, by their names. Raises `InputError` of one given twice."""
    if len(found := dict(given)) < len(given):
        raise InputError(Fault(f"--{name}", "is given twice", "give each by its name: NAME=X,Y,Z,A,B,C"))
    return found


def only_frame(name: str, given: Sequence[tuple[str, Array]]) -> Array | None:
    """(4, 4) the one frame that `--name` gives, None without. Raises `InputError` of frames with names."""
    found = frames_given(name, given)
    if any(found):
        raise InputError(Fault(f"--{name}", "with a name is for programs", "give one frame without"))
    return found.get("")


def numbers(text: str) -> Array:
    """(n,) numbers with commas between."""
    import numpy as np

    if not (told := _listed(text)):
        raise argparse.ArgumentTypeError(f"{text!r} are no numbers with commas between")
    return np.array(told)


def _listed(text: str) -> list[float]:
    """Finite numbers with commas between; empty where they are none."""
    try:
        told = [float(word) for word in text.split(",")]
    except ValueError:
        return []
    return told if all(map(isfinite, told)) else []


def above_zero(what: str) -> Callable[[str], float]:
    """What reads a number above zero: `what` it is, for the message."""

    def read(text: str) -> float:
        if len(told := _listed(text)) != 1 or not 0 < told[0] <= MOST:
            raise argparse.ArgumentTypeError(f"{text!r} is no {what} above zero, or too large")
        return told[0]

    return read


def not_negative(what: str, most: float = MOST) -> Callable[[str], float]:
    """What reads a number from zero to `most`: `what` it is, for the message."""

    def read(text: str) -> float:
        if len(told := _listed(text)) != 1 or not 0 <= told[0] <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is no {what} of zero or more, or too large")
        return told[0]

    return read


def positive(text: str) -> int:
    """A whole number from 1, of things to make."""
    if (count := _whole(text, 1)) > MOST:
        raise argparse.ArgumentTypeError(f"{text!r} is too many: {MOST} are the most")
    return count


def from_zero(text: str) -> int:
    """A whole number from 0."""
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    if not text.isdecimal() or int(text) < least:
        raise argparse.ArgumentTypeError(f"{text!r} is no number from {least}")
    return int(text)


def check_folder(out: Path | None) -> None:
    """Raises InputError where the folder cannot be made: a file is in the way, or nobody may write there."""
    there = next((place for place in (out, *out.parents) if os.path.lexists(place)), None) if out else None
    if there is not None and not there.is_dir():
        raise InputError(Fault(str(there), "is a file, not a folder", "name another place with --out"))
    if there is not None and not os.access(there, os.W_OK | os.X_OK):
        raise InputError(Fault(str(there), "nobody may write there", "name another place with --out"))


def load_all(paths: Sequence[str], *, tell: bool = True) -> list[Campaign]:
    """All campaigns, their warnings told (unless the command says them itself); `InputError` with the faults
    of all."""
    from ..campaign import load_campaign

    campaigns: list[Campaign] = []
    faults: list[Fault] = []
    for path in paths:
        try:
            campaigns.append(load_campaign(path))
        except InputError as error:
            faults += error.faults
    if faults:
        raise InputError(faults)
    for campaign in campaigns if tell else []:
        for warning in campaign.warnings:
            warn(warning)
    return campaigns


def stated(campaign: str | None) -> Campaign | None:
    """The campaign that is named beside a model, its warnings told; None where there is none."""
    return load_all([campaign])[0] if campaign else None


def started(model: str, told: Array | None) -> Array | None:
    """(n,) joints [rad, m] of a posture that is told in degrees and millimetres; None where none is. Raises
    InputError."""
    import numpy as np

    from ..robot.description import load_robot

    if told is None:
        return None
    robot = load_robot(model)
    if len(told) != len(robot.joints):
        what = f"has {len(told)} numbers, {robot.name} has {len(robot.joints)} joints"
        raise InputError(Fault("--start", what, f"one for each of {', '.join(robot.joint_names)}"))
    return np.where(robot.sliding, 1e-3 * told, np.radians(told))


def conditions(model: str, payload: str, campaign: Campaign | None, told: bool = True) -> Conditions:
    """Tool and payload along the path, as the campaign or else the model states them; told: with a word
    where no payload of the model's is taken. Raises InputError for the campaign of another robot."""
    from ..campaign.other_tools import tool_as_modelled
    from ..campaign.same_robot import check_same_robot
    from ..correction.conditions import conditions_of, stated_conditions
    from ..robot.description import load_robot

    robot = load_robot(model)
    if campaign is not None:
        check_same_robot(robot, campaign)
        mounted = tool_as_modelled(robot, campaign)
        if mounted is not campaign and payload in campaign.payload_names:
            payload = mounted.payload_names[campaign.payload_names.index(payload) + 1]
        return conditions_of(mounted, payload)
    if told and robot.payloads and not payload:
        known = ", ".join(robot.payloads)
        taken = f"{robot.mounted}, the tool mounted last" if robot.mounted else "no payload"
        progress(f"the arm is taken to carry {taken}; the model knows {known} (--payload NAME)")
    return stated_conditions(robot, payload)
