"""`workbench study`, and a study's script as a program of its own."""

from __future__ import annotations

import argparse
import json
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from ..files.faults import Fault, InputError
from ..studies import PUBLISHED
from .arguments import (
    Commands,
    check_folder,
    json_option,
    out_option,
    positive,
    quick_option,
    seed_option,
    workers_option,
)
from .status import guarded, progress

if TYPE_CHECKING:
    from ..studies.running import Script
    from ..studies.study_run import StudyRun


def add(commands: Commands) -> None:
    parser = commands.add_parser("study", help="the published studies, and our own error rates")
    studies = parser.add_subparsers(dest="name", required=True, metavar="NAME")
    for name, about in PUBLISHED.items():
        _script_options(studies.add_parser(name, help=f"published: {about}"), f"reports/{name}")
    _script_options(studies.add_parser("all", help="all published ones, and a list of them"), "reports")
    for name in (*PUBLISHED, "all"):
        studies.choices[name].set_defaults(run=run)
    _add_archive(studies)
    _add_blind(studies)
    _add_case(studies)
    _add_followup(studies)


def _script_options(parser: argparse.ArgumentParser, folder: str) -> None:
    out_option(parser, f"folder for the page, the report, the scene and the numbers ({folder})", folder)
    seed_option(parser, "all that is simulated")
    quick_option(parser, "fewer poses and draws; not the figures that the study is judged by")
    workers_option(parser)
    parser.add_argument("--resume", action="store_true", help="take the draws of a stopped run, and go on")
    parser.add_argument(
        "--measured", type=Path, metavar="DIR", help="measured campaigns (see README), for the same question"
    )
    json_option(parser)


def _add_archive(studies: Commands) -> None:
    what = "a study's campaigns as a zip, the truth sealed apart, for others to diagnose blind"
    parser = studies.add_parser("archive", help=what)
    parser.add_argument("study", choices=PUBLISHED, metavar="NAME", help="a published study that was run")
    parser.add_argument(
        "--results", type=Path, metavar="DIR", help="where it wrote its results (default: reports/NAME)"
    )
    out_option(parser, "file for the zip (default: beside the results, NAME.zip)")
    json_option(parser)
    parser.set_defaults(run=run_archive)


def _add_blind(studies: Commands) -> None:
    parser = studies.add_parser("blind", help="our own error rates, on robots and faults drawn at random")
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--draws", type=positive, default=20, metavar="N", help="draws per cause (20)")
    size.add_argument("--quick", action="store_true", help="faster: two cases of a few causes")
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="a Dask scheduler, whose workers on other machines do the cases",
    )
    _case_options(parser, "reports/blind")
    parser.set_defaults(run=run_blind)


def _case_options(parser: argparse.ArgumentParser, folder: str) -> None:
    """Of a study that counts many cases."""
    out_option(parser, f"folder for the page, the rates and every case ({folder})", folder)
    seed_option(parser, "all cases")
    workers_option(parser)
    parser.add_argument("--resume", action="store_true", help="go on where a stopped run ended")
    json_option(parser)


def _add_case(studies: Commands) -> None:
    parser = studies.add_parser("case", help="cases of the blind study again: what was hidden, what was said")
    parser.add_argument("keys", nargs="+", metavar="KEY", help="like gear_ratio/3, pair/0, clean-stated/2")
    out_option(parser, "folder under which each diagnosis' page is written (default: none is)")
    seed_option(parser, "the study")
    workers_option(parser)
    json_option(parser)
    parser.set_defaults(run=run_case)


def _add_followup(studies: Commands) -> None:
    what = "faults that stay open, the follow-up that is offered, and what both campaigns say together"
    parser = studies.add_parser("followup", help=what)
    parser.add_argument("--draws", type=positive, default=5, metavar="N", help="draws per cause (5)")
    _case_options(parser, "reports/followup")
    parser.set_defaults(run=run_followup)


def run(arguments: argparse.Namespace) -> None:
    from ..studies.running import run_published

    everything, folder = arguments.name == "all", arguments.out
    check_folder(folder)
    if not everything:
        _check_unmixed(folder, arguments.name)
    found = run_published(tuple(PUBLISHED) if everything else (arguments.name,), _asked(arguments))
    if arguments.json:
        results = [study.to_json() for study in found]
        print(json.dumps(results if everything else results[0]))
    else:
        print("\n\n".join(study.text for study in found), f"open {folder}/index.html", sep="\n\n")


def _check_unmixed(folder: Path, name: str) -> None:
    """Raises InputError where a study would mix its files with those of another result."""
    there = {"study": name}
    with suppress(OSError, ValueError):
        there = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    other = there.get("study") if isinstance(there, dict) else None
    if other != name:
        what = f"the study {other}" if other else "another result"
        mend = "give another folder with --out, or remove this one first"
        raise InputError(Fault(str(folder), f"holds {what}", mend))


def _asked(arguments: argparse.Namespace) -> StudyRun:
    from ..studies.study_run import StudyRun

    return StudyRun(
        arguments.out,
        arguments.seed,
        arguments.quick,
        arguments.workers,
        arguments.resume,
        progress,
        arguments.measured,
    )


def run_archive(arguments: argparse.Namespace) -> None:
    from ..studies.archive import archive

    folder = arguments.results or Path("reports") / arguments.study
    out = archive(folder, arguments.out or folder.parent / f"{arguments.study}.zip")
    print(json.dumps({"archive": str(out)}) if arguments.json else f"wrote {out}")


def run_blind(arguments: argparse.Namespace) -> None:
    from ..studies.blind import blind

    check_folder(arguments.out)
    result = blind(
        arguments.out,
        arguments.draws,
        arguments.seed,
        arguments.workers,
        arguments.resume,
        arguments.quick,
        scheduler=arguments.scheduler,
    )
    print(json.dumps(result.to_json()) if arguments.json else result.text)


def run_followup(arguments: argparse.Namespace) -> None:
    from ..studies.followup import followup

    check_folder(arguments.out)
    result = followup(arguments.out, arguments.draws, arguments.seed, arguments.workers, arguments.resume)
    print(json.dumps(result.to_json()) if arguments.json else result.text)


def run_case(arguments: argparse.Namespace) -> None:
    from ..studies.blind.blind_page import miss_cells
    from ..studies.blind.one import cases_again

    check_folder(arguments.out)
    for record in cases_again(arguments.keys, arguments.seed, arguments.out, arguments.workers):
        print(json.dumps(record) if arguments.json else " | ".join(miss_cells(record)), flush=True)


def run_study(script: Script) -> NoReturn:
    """A study's script as a program of its own: `python my_study.py [--quick] [--out DIR] ...`."""
    module = sys.modules[script.__module__]
    parser = argparse.ArgumentParser(description=module.__doc__)
    name = Path(module.__file__ or "study/study.py").resolve().parent.name
    _script_options(parser, f"reports/{name}")

    def action() -> None:
        given = parser.parse_args()
        check_folder(given.out)
        _check_unmixed(given.out, name)
        from ..studies.running import run_script  # only now: a wrong call is answered at once

        found = run_script(script, _asked(given))
        print(json.dumps(found.to_json()) if given.json else found.text)

    sys.exit(guarded(action))
