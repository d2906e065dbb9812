"""`workbench check`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from ..files.faults import Fault, InputError
from .arguments import Commands, check_folder, json_option, out_option
from .plan import read_source


def add(commands: Commands) -> None:
    parser = commands.add_parser("check", help="reads, draws and tests a robot or a campaign before any fit")
    parser.add_argument("source", metavar="ROBOT|CAMPAIGN.toml", help="a robot's name or TOML, or a campaign")
    out_option(parser, "folder for the page and the scene (reports/check)", "reports/check")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..campaign import Campaign
    from ..campaign.own_weight import too_weak
    from ..diagnosis.first_look import first_look
    from ..report.first_look import check_campaign, check_robot, write_check
    from ..robot.shown import urdf_notes

    folder: Path = arguments.out
    check_folder(folder)
    source = read_source(arguments.source, tell=False)  # the page and its text say the warnings
    wrong: tuple[Fault, ...] = ()
    if isinstance(source, Campaign):
        look = first_look(source)
        checked, wrong = check_campaign(look), look.wrong
    else:
        checked = check_robot(source, [*urdf_notes(source), *too_weak(source)])
    write_check(checked, folder)
    print(json.dumps(checked.facts) if arguments.json else f"{checked.text}\n\nopen {folder}/index.html")
    if wrong:
        raise InputError(wrong)  # drawn all the same: the picture often says why
