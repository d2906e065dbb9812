"""`workbench export`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from .arguments import Commands, check_folder, conditions, json_option, load_options, out_option, stated


def add(commands: Commands) -> None:
    parser = commands.add_parser("export", help="the corrected robot for other programs")
    parser.add_argument("model", metavar="MODEL.toml", help="what diagnose wrote, or a robot by name")
    # no choices here: the formats take long to import
    formats = "urdf, sdf, drake, mjcf, ur-kinematics, dh, opw"
    parser.add_argument("--to", required=True, metavar="FORMAT", help=formats)
    besides = "; its poses are those where the geometry is fitted and errors are told (default: drawn ones)"
    load_options(parser, besides)
    out_option(parser, "folder (reports/export/FORMAT)")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..simulation.export import export

    out = arguments.out or Path("reports/export") / arguments.to
    check_folder(out)
    campaign = stated(arguments.campaign)
    loads = conditions(arguments.model, arguments.payload, campaign)
    written = export(arguments.model, arguments.to, out, campaign=campaign, conditions=loads)
    print(json.dumps(written.to_json()) if arguments.json else written.text)
