"""What the arguments of the command line mean: common options, campaigns, loads, folders."""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .files.faults import Fault, InputError

if TYPE_CHECKING:
    from .campaign import Campaign
    from .correction import Conditions


def common(parser: argparse.ArgumentParser, out: str | None = None) -> None:
    parser.add_argument("--out", type=Path, default=Path(out) if out else None, help="where results go")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--json", action="store_true", help="the result to standard output, nothing else there"
    )
    parser.add_argument("--quick", action="store_true", help="smaller and faster")
    parser.add_argument("--workers", type=int, default=None, help="processes (default: all cores)")
    parser.add_argument("--resume", action="store_true", help="go on where a stopped run ended")


def guarded(action: Callable[[], int]) -> int:
    """Exit status of an action: its own (0), 2 when the input or the call is wrong, 1 when it failed."""
    for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(threads, "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without µ is no reason to fail
    try:
        return action()
    except InputError as error:
        for fault in error.faults:
            print(f"error: {fault}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 1
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        if os.environ.get("WORKBENCH_DEBUG"):
            raise
        print(f"failed: {type(error).__name__}: {error} (WORKBENCH_DEBUG=1 shows where)", file=sys.stderr)
        return 1


def progress(message: str) -> None:
    print(f"… {message}", file=sys.stderr, flush=True)


def check_folder(out: Path | None) -> None:
    if out is not None and out.exists() and not out.is_dir():
        raise InputError(Fault(str(out), "is a file, not a folder", "name a folder with --out"))


def load_all(paths: Sequence[str]) -> list[Campaign]:
    """All campaigns, their warnings told; `InputError` with the faults of all."""
    from .campaign import load_campaign

    campaigns: list[Campaign] = []
    faults: list[Fault] = []
    for path in paths:
        try:
            campaigns.append(load_campaign(path))
        except InputError as error:
            faults += error.faults
    if faults:
        raise InputError(faults)
    for campaign in campaigns:
        for warning in campaign.warnings:
            print(f"warning: {warning}", file=sys.stderr)
    return campaigns


def load_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--payload", default="", metavar="NAME", help="what the arm carries (default: nothing)"
    )
    parser.add_argument(
        "--campaign", metavar="CAMPAIGN.toml", help="where tool and payload are stated (default: the model)"
    )


def conditions(arguments: argparse.Namespace) -> Conditions:
    """Tool and payload along the path, as the campaign or else the model states them."""
    from .correction import conditions_of, stated_conditions
    from .robot.description import load_robot

    if arguments.campaign:
        (campaign,) = load_all([arguments.campaign])
        return conditions_of(campaign, arguments.payload)
    robot = load_robot(arguments.model)
    if robot.payloads and not arguments.payload:
        known = ", ".join(robot.payloads)
        progress(f"the arm is taken to carry no payload; the model knows {known} (--payload NAME)")
    return stated_conditions(robot, arguments.payload)
