"""`workbench compensate`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from ..files.faults import Fault, InputError
from .arguments import (
    Commands,
    check_folder,
    conditions,
    frames_given,
    frames_option,
    json_option,
    load_options,
    not_negative,
    only_frame,
    out_option,
    program_options,
    seed_option,
    start_option,
    started,
    stated,
)
from .status import warn


def add(commands: Commands) -> None:
    parser = commands.add_parser(
        "compensate", help="the commands that put the real tool on a path; or a program corrected"
    )
    parser.add_argument(
        "path",
        metavar="PATH.csv|PROGRAM",
        help="t_s and joints, or tool poses in the base frame; or a program (.src, .mod, .pjx, .ls, "
        ".script), whose targets are corrected and the rest left as it is",
    )
    parser.add_argument("--model", required=True, metavar="MODEL.toml", help="what diagnose wrote")
    # no choices here: the formats are the files of correction/programs, which take long to import
    parser.add_argument(
        "--format", help="csv (if not said), krl, rapid, val3, ls, urscript; of a program: its own"
    )
    parser.add_argument("--joints", action="store_true", help="targets of joints in place of tool poses")
    parser.add_argument(
        "--tolerance", type=not_negative("length"), metavar="MM",
        help="fewest lines and circles within this of the path (0.01); 0 keeps every point",
    )  # fmt: skip
    frames_option(parser, "tool", "tool in the flange frame, whose poses a path of tool poses gives")
    frames_option(parser, "base", "frame of the poses in the controller's world")
    start_option(parser)
    load_options(parser)
    out_option(
        parser,
        "the program's file, or a folder (default: beside the path, NAME_compensated)",
    )
    program_options(parser)
    seed_option(parser, "the postures that are tried for the first pose")
    json_option(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    from ..correction.file import TOLERANCE_MM, Export, compensate_file
    from ..correction.in_place import compensate_program, is_program

    check_folder(arguments.out.parent if arguments.out else None)
    of_program = is_program(Path(arguments.path))
    campaign = stated(arguments.campaign)
    loads = conditions(arguments.model, arguments.payload, campaign, told=not of_program)
    start = started(arguments.model, arguments.start)
    if of_program:
        for name, said in (("--joints", arguments.joints), ("--tolerance", arguments.tolerance is not None)):
            if said:
                raise InputError(Fault(name, "is for paths: a program keeps its own points", "leave it out"))
        written = compensate_program(
            arguments.path,
            arguments.model,
            arguments.out,
            format=arguments.format,
            conditions=loads,
            tool=frames_given("tool", arguments.tool),
            base=frames_given("base", arguments.base),
            start=start,
            as_urdf=arguments.as_urdf,
            keep=not arguments.force,
        )
        print(json.dumps(written.to_json()) if arguments.json else written.text)
        return
    export = Export(
        base=only_frame("base", arguments.base),
        joints=arguments.joints,
        tolerance_mm=TOLERANCE_MM if arguments.tolerance is None else arguments.tolerance,
        as_urdf=arguments.as_urdf,
        keep=not arguments.force,
    )
    done = compensate_file(
        arguments.path,
        arguments.model,
        arguments.format or "csv",
        arguments.out,
        conditions=loads,
        tool=only_frame("tool", arguments.tool),
        start=start,
        seed=arguments.seed,
        export=export,
    )
    for warning in done.warnings:
        warn(warning)
    print(json.dumps(done.to_json()) if arguments.json else done.text)
