"""`workbench demo`."""

from __future__ import annotations

import argparse
import json

from .arguments import Commands, check_folder, json_option, out_option, quick_option, seed_option
from .status import progress


def add(commands: Commands) -> None:
    parser = commands.add_parser("demo", help="the whole loop on a simulated robot")
    out_option(parser, "folder for the campaign, the page and the proof (reports/demo)", "reports/demo")
    seed_option(parser, "poses, hidden geometry and noise", default=3)
    quick_option(parser, "fewer poses, a smaller circle")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..studies.demo import demo

    check_folder(arguments.out)
    summary = demo(arguments.out, arguments.seed, progress, arguments.quick)
    print(json.dumps(summary.to_json()) if arguments.json else summary.text)
