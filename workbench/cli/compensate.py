"""`workbench compensate`."""

from __future__ import annotations

import argparse
import json

from .arguments import Commands, conditions, json_option, load_options, out_option, seed_option


def add(commands: Commands) -> None:
    parser = commands.add_parser("compensate", help="offline path modification")
    parser.add_argument("path", metavar="PATH.csv", help="t_s and joints, or tool poses in the base frame")
    parser.add_argument("--model", required=True, metavar="MODEL.toml", help="what diagnose wrote")
    # no choices here: the formats are the files of correction/programs, which take long to import
    parser.add_argument("--format", default="csv", help="csv (if not said), krl, rapid, val3, ls, urscript")
    load_options(parser)
    out_option(
        parser,
        "the program's file, or a folder that is there (default: beside the path, NAME_compensated)",
    )
    seed_option(parser, "the postures that are tried for the first pose")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..correction import compensate_file

    written = compensate_file(
        arguments.path,
        arguments.model,
        arguments.format,
        arguments.out,
        conditions=conditions(arguments.model, arguments.payload, arguments.campaign),
        seed=arguments.seed,
    )
    print(json.dumps(written.to_json()) if arguments.json else written.text)
