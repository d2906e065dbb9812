"""`workbench verify`."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

from .arguments import (
    Commands,
    above_zero,
    check_folder,
    conditions,
    json_option,
    load_options,
    out_option,
    quick_option,
    seed_option,
    start_option,
    started,
    stated,
    tool_option,
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
    parser.add_argument(
        "--speed",
        type=above_zero("speed"),
        action="append",
        metavar="M/S",
        help="tool speed, repeatable (0.03 and 0.3): 95 %% of the path is no faster",
    )
    parser.add_argument(
        "--controller", metavar="FILE.toml", help="its [controller.loop] instead of that of the truth"
    )
    parser.add_argument(
        "--feed-forward",
        choices=("static", "elastic", "loop"),
        default="static",
        help="drives also lead by the arm's deflection under its inertia (elastic), and by the lag that the "
        "model's own loop predicts (loop)",
    )
    parser.add_argument(
        "--on-limit",
        choices=("stop", "saturate"),
        default="stop",
        help="what a drive does that is asked for more torque or speed than its limit (stop)",
    )
    parser.add_argument("--sweep", action="store_true", help="error by speed too, 0.01 to 1 m/s")
    tool_option(parser)
    start_option(parser)
    load_options(parser)
    out_option(parser, "folder for the page, the scene and the numbers (reports/verify)", "reports/verify")
    seed_option(parser, "repeated runs, and of the postures tried for the first pose")
    quick_option(parser, f"{QUICK_REPEATS} repeated runs instead of {REPEATS}")
    workers_option(parser)
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..robot.schema import parse_loop
    from ..simulation.closed_loop import verify_file
    from ..simulation.closed_loop.proof import SPEEDS

    check_folder(arguments.out)
    done = verify_file(
        arguments.path,
        arguments.model,
        arguments.truth,
        arguments.out,
        conditions=conditions(arguments.model, arguments.payload, stated(arguments.campaign)),
        tool=arguments.tool,
        start=started(arguments.model, arguments.start),
        speeds=arguments.speed or SPEEDS,
        loop=parse_loop(Path(arguments.controller)) if arguments.controller else None,
        feed_forward=arguments.feed_forward,
        on_limit=arguments.on_limit,
        sweep=arguments.sweep,
        repeats=QUICK_REPEATS if arguments.quick else REPEATS,
        seed=arguments.seed,
        workers=arguments.workers or os.cpu_count() or 1,
        beside=[Path(name) for name in (arguments.controller, arguments.campaign) if name],
        progress=progress,
    )
    print(json.dumps(done.to_json()) if arguments.json else done.text)
