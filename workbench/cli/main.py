"""The command line. Thin: it reads arguments, calls the verbs, prints. Imports are late: help is instant."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..arguments import check_folder, common, conditions, guarded, load_all, load_options, progress
from ..studies import PUBLISHED

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command; exit status 0 done, 2 the input or the call is wrong, 1 the program failed."""

    def action() -> int:
        arguments = _parser().parse_args(argv)
        return int(arguments.run(arguments) or 0)

    return guarded(action)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="workbench",
        description="What a robot's simulation gets wrong, why, and how to draw the right path all the same.",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for add in (_demo, _diagnose, _simulate, _plan, _compensate, _verify, _study, _robots, _causes):
        add(commands)
    return parser


def _demo(commands: Commands) -> None:
    parser = commands.add_parser("demo", help="the whole loop on a simulated robot")
    common(parser, "reports/demo")

    def run(arguments: argparse.Namespace) -> int:
        from ..studies.demo import demo

        check_folder(arguments.out)
        summary = demo(arguments.out, arguments.seed, progress, arguments.quick)
        print(json.dumps(summary.to_json()) if arguments.json else summary.text)
        return 0

    parser.set_defaults(run=run)


def _diagnose(commands: Commands) -> None:
    parser = commands.add_parser(
        "diagnose", help="what the simulation gets wrong, why, and the gain of saying so"
    )
    parser.add_argument("campaigns", nargs="+", metavar="CAMPAIGN.toml")
    parser.add_argument(
        "--test", metavar="CAMPAIGN.toml", help="judge on this campaign; nothing is fitted on it"
    )
    common(parser)

    def run(arguments: argparse.Namespace) -> int:
        from ..diagnosis.run import diagnose

        check_folder(arguments.out)
        campaigns = load_all([*arguments.campaigns, *([arguments.test] if arguments.test else [])])
        test = campaigns.pop() if arguments.test else None
        outcome = diagnose(campaigns, test, progress, arguments.seed)
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
        return 0

    parser.set_defaults(run=run)


def _simulate(commands: Commands) -> None:
    parser = commands.add_parser(
        "simulate", help="a campaign from the Drake model, with chosen effects and noise"
    )
    parser.add_argument("robot", metavar="ROBOT", help="a name or the path of a robot TOML")
    poses = parser.add_mutually_exclusive_group(required=True)
    poses.add_argument("--poses", metavar="FILE", help="poses.csv with q1_deg ... as in a campaign")
    poses.add_argument("--random", type=int, metavar="N", help="N random poses within the limits")
    poses.add_argument(
        "--grid", metavar="JOINT=FROM:TO:COUNT,...", help="joints on a grid, deg or mm; others at 0"
    )
    parser.add_argument("--effect", action="append", default=[], metavar="ID:key=value,...")
    parser.add_argument(
        "--payload",
        action="append",
        default=[],
        metavar="NAME=KG[:x,y,z mm]",
        help="measured with it besides without; NAME alone for one that a model.toml states",
    )
    parser.add_argument("--tool", metavar="KG[:x,y,z mm]", help="always mounted (default: the model's)")
    parser.add_argument("--sigma-mm", type=float, default=0.03, help="noise per axis, one sigma (0.03)")
    parser.add_argument(
        "--geometry-mm", type=float, default=0.5, help="random errors of lengths, one sigma (0.5)"
    )
    parser.add_argument(
        "--geometry-mrad", type=float, default=0.5, help="random errors of angles, one sigma (0.5)"
    )
    parser.add_argument("--shots", type=int, default=1)
    parser.add_argument("--approach", action="store_true", help="record random sides of approach (dir1 ...)")
    parser.add_argument("--hours", type=float, default=0.0, help="record times over so many hours")
    parser.add_argument(
        "--warm-degC", type=float, default=0.0, help="record a warm-up from 20 °C by this much"
    )
    common(parser, "reports/simulated")

    def run(arguments: argparse.Namespace) -> int:
        from .simulate import simulate_command

        check_folder(arguments.out)
        campaign = simulate_command(arguments)
        facts = {"robot": campaign.robot.name, "n_poses": len(campaign.q), "folder": str(arguments.out)}
        print(
            json.dumps(facts)
            if arguments.json
            else f"{len(campaign.q)} poses written to {arguments.out}/campaign.toml"
        )
        return 0

    parser.set_defaults(run=run)


def _plan(commands: Commands) -> None:
    parser = commands.add_parser(
        "plan", help="the next measurements: for accuracy, or to tell rival causes apart"
    )
    parser.add_argument(
        "source", metavar="CAMPAIGN.toml|ROBOT", help="what was measured already, or a robot's name or TOML"
    )
    parser.add_argument("--poses", type=int, default=30, metavar="N", help="how many records (30)")
    parser.add_argument(
        "--tell",
        metavar="CAUSE,CAUSE",
        help="two causes as in --effect, without numbers: gear_ratio:joint=joint_2,link_mass:link=link_2; "
        "what is left out (joint, link, payload, variant) is tried everywhere: gear_ratio,hose_torque",
    )
    common(parser, "reports/plan/poses.csv")

    def run(arguments: argparse.Namespace) -> int:
        from ..measurement.design.next_poses import plan_command

        print(plan_command(arguments, progress))
        return 0

    parser.set_defaults(run=run)


def _compensate(commands: Commands) -> None:
    parser = commands.add_parser("compensate", help="offline path modification")
    parser.add_argument("path", metavar="PATH.csv")
    parser.add_argument("--model", required=True, metavar="MODEL.toml")
    parser.add_argument("--format", default="csv", choices=("csv", "krl", "rapid", "val3", "ls", "urscript"))
    load_options(parser)
    common(parser)

    def run(arguments: argparse.Namespace) -> int:
        from ..correction import compensate_file

        written = compensate_file(
            arguments.path,
            arguments.model,
            arguments.format,
            arguments.out,
            conditions=conditions(arguments),
            seed=arguments.seed,
        )
        print(json.dumps(written.to_json()) if arguments.json else written.text)
        return 0

    parser.set_defaults(run=run)


def _verify(commands: Commands) -> None:
    parser = commands.add_parser(
        "verify", help="closed-loop Drake simulation of a path, with and without compensation"
    )
    parser.add_argument("path", metavar="PATH.csv")
    parser.add_argument("--model", required=True, metavar="MODEL.toml", help="what the compensation knows")
    parser.add_argument("--truth", metavar="MODEL.toml", help="what is simulated (default: the model)")
    load_options(parser)
    common(parser, "reports/verify")

    def run(arguments: argparse.Namespace) -> int:
        from ..simulation.closed_loop import verify_file

        done = verify_file(
            arguments.path,
            arguments.model,
            arguments.truth,
            arguments.out,
            conditions=conditions(arguments),
            repeats=2 if arguments.quick else 10,
            seed=arguments.seed,
            workers=arguments.workers or os.cpu_count() or 1,
            progress=progress,
        )
        print(json.dumps(done.to_json()) if arguments.json else done.text)
        return 0

    parser.set_defaults(run=run)


def _study(commands: Commands) -> None:
    parser = commands.add_parser("study", help="the published studies, and our own error rates (blind)")
    parser.add_argument("name", choices=(*PUBLISHED, "all", "blind"))
    parser.add_argument("--draws", type=int, default=20, help="blind: draws per cause (20)")
    common(parser)

    def run(arguments: argparse.Namespace) -> int:
        name = arguments.name
        folder = arguments.out or Path("reports") / ("" if name == "all" else name)
        check_folder(folder)
        if name == "blind":
            return _blind(arguments, folder)
        from ..studies.running import run_published

        names = PUBLISHED if name == "all" else (name,)
        found = run_published(names, folder, arguments.seed, arguments.quick, progress)
        if arguments.json:
            results = [study.to_json() for study in found]
            print(json.dumps(results if name == "all" else results[0]))
        else:
            print("\n\n".join(study.text for study in found), f"open {folder}/index.html", sep="\n\n")
        return 0

    parser.set_defaults(run=run)


def _blind(arguments: argparse.Namespace, folder: Path) -> int:
    from ..studies.blind import blind

    result = blind(
        folder, arguments.draws, arguments.seed, arguments.workers, arguments.resume, arguments.quick
    )
    print(json.dumps(result.to_json()) if arguments.json else result.text)
    return 0


def _robots(commands: Commands) -> None:
    parser = commands.add_parser("robots", help="the robots that come with the workbench")
    parser.add_argument("--json", action="store_true")

    def run(arguments: argparse.Namespace) -> int:
        from ..robot.description import load_robot
        from ..robot.find import list_robots

        robots = [load_robot(path) for path in list_robots()]
        if arguments.json:
            print(json.dumps([{"name": r.name, "title": r.title, "joints": len(r.joints)} for r in robots]))
        else:
            for r in robots:
                print(f"{r.name:<14} {len(r.joints)} joints   {r.title}")
        return 0

    parser.set_defaults(run=run)


def _causes(commands: Commands) -> None:
    parser = commands.add_parser("causes", help="the causes that a diagnosis can name")
    parser.add_argument("--json", action="store_true")

    def run(arguments: argparse.Namespace) -> int:
        from ..effects import catalogue

        if arguments.json:
            print(json.dumps([{"cause": key, "title": kind.title} for key, kind in catalogue().items()]))
        else:
            for key, kind in catalogue().items():
                print(f"{key:<22} {kind.title}")
        return 0

    parser.set_defaults(run=run)
