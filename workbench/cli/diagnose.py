"""`workbench diagnose`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from .arguments import (
    Commands,
    check_folder,
    json_option,
    known_option,
    load_all,
    out_option,
    seed_option,
)
from .status import loading, progress, warn


def add(commands: Commands) -> None:
    parser = commands.add_parser(
        "diagnose", help="what the simulation gets wrong, why, and the gain of saying so"
    )
    parser.add_argument(
        "campaigns",
        nargs="+",
        metavar="CAMPAIGN.toml",
        help="of one robot: fitted together; where it changed between them, the model is of the last",
    )
    parser.add_argument(
        "--test", metavar="CAMPAIGN.toml", help="judge on this campaign; nothing is fitted on it"
    )
    known_option(parser)
    out_option(
        parser,
        "folder for the page, report, scene, model and numbers (reports/ and the name of the campaign's "
        "folder; with --json nothing is written unless this is given)",
    )
    seed_option(parser, "the groups of poses that are held out in turn")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    with loading():
        from ..diagnosis.all_over import with_bounds
        from ..diagnosis.run import diagnose
        from ..measurement.design import what_decides

    check_folder(arguments.out)
    campaigns = load_all([*arguments.campaigns, *([arguments.test] if arguments.test else [])])
    test = campaigns.pop() if arguments.test else None
    moved = (campaigns.pop(0) for _ in arguments.campaigns)  # of a large one, what is fitted is kept alone
    outcome = diagnose([*moved], test, progress, arguments.seed, arguments.known)
    progress("working out what would decide")
    outcome = with_bounds(what_decides(outcome))
    for note in outcome.prepared.notes:
        warn(note)
    folder = arguments.out
    if folder is None and not arguments.json:
        folder = Path("reports") / Path(arguments.campaigns[0]).resolve().parent.name
    if folder is not None:
        from ..report.outcome import write_outcome

        progress("writing the page, the report and the scene")
        write_outcome(outcome, folder)
    if arguments.json:
        print(json.dumps(outcome.diagnosis.to_json()))
    else:
        from ..report.terminal import short_verdict

        print(short_verdict(outcome.diagnosis, folder))
