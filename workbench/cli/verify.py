"""`workbench verify`."""

from __future__ import annotations

import argparse
import json
import os

from .arguments import (
    Commands,
    conditions,
    json_option,
    load_options,
    out_option,
    quick_option,
    seed_option,
    workers_option,
)
from .status import progress

REPEATS, QUICK_REPEATS = 10, 2  # runs behind accuracy AT and repeatability RT of the path


def add(commands: Commands) -> None:
    parser = commands.add_parser(
        "verify", help="closed-loop Drake simulation of a path, with and without compensation"
    )
    parser.add_argument("path", metavar="PATH.csv", help="t_s and joints, or tool poses in the base frame")
    parser.add_argument("--model", required=True, metavar="MODEL.toml", help="what the compensation knows")
    parser.add_argument("--truth", metavar="MODEL.toml", help="what is simulated (default: the model)")
    load_options(parser)
    out_option(parser, "folder for the page, the scene and the numbers (reports/verify)", "reports/verify")
    seed_option(parser, "repeated runs, and of the postures tried for the first pose")
    quick_option(parser, f"{QUICK_REPEATS} repeated runs instead of {REPEATS}")
    workers_option(parser)
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..simulation.closed_loop import verify_file

    done = verify_file(
        arguments.path,
        arguments.model,
        arguments.truth,
        arguments.out,
        conditions=conditions(arguments.model, arguments.payload, arguments.campaign),
        repeats=QUICK_REPEATS if arguments.quick else REPEATS,
        seed=arguments.seed,
        workers=arguments.workers or os.cpu_count() or 1,
        progress=progress,
    )
    print(json.dumps(done.to_json()) if arguments.json else done.text)
