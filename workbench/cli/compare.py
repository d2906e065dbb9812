"""`workbench compare`."""

from __future__ import annotations

import argparse
import json

from .arguments import Commands, check_folder, json_option, known_option, load_all, out_option
from .status import DONE, progress


def add(commands: Commands) -> None:
    parser = commands.add_parser("compare", help="what changed between campaigns of one robot")
    parser.add_argument(
        "campaigns", nargs="+", metavar="CAMPAIGN.toml", help="two or more of one robot, in the order of time"
    )
    known_option(parser)
    out_option(
        parser, "folder for the page, the report and the numbers (nothing is written unless this is given)"
    )
    parser.add_argument(
        "--exit-code", action="store_true", help="end with status 3 where the robot changed, for scripts"
    )
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    from ..diagnosis.changes import compare

    check_folder(arguments.out)
    comparison = compare(load_all(arguments.campaigns), progress, arguments.known)
    if arguments.out is not None:
        from ..report.comparison import write_comparison

        write_comparison(comparison, arguments.out)
    if arguments.json:
        print(json.dumps(comparison.to_json()))
    else:
        from ..report.comparison import short_comparison

        print(short_comparison(comparison, arguments.out))
    return comparison.exit_status if arguments.exit_code else DONE
