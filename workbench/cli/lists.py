"""`workbench robots` and `workbench causes`: what there is, a line each."""

from __future__ import annotations

import argparse
import json
from typing import Any

from .arguments import Commands, json_option

SHOWN = 6  # parameters of a cause in its line


def add(commands: Commands) -> None:
    parser = commands.add_parser("robots", help="the robots that come with the workbench")
    json_option(parser)
    parser.set_defaults(run=robots)
    parser = commands.add_parser("causes", help="the causes that a diagnosis can name")
    json_option(parser)
    parser.set_defaults(run=causes)


def robots(arguments: argparse.Namespace) -> None:
    from ..robot.description import load_robot
    from ..robot.find import list_robots

    found = [load_robot(path) for path in list_robots()]
    if arguments.json:
        print(json.dumps([{"name": r.name, "title": r.title, "joints": len(r.joints)} for r in found]))
    else:
        for r in found:
            print(f"{r.name:<14} {len(r.joints)} joints   {r.title}")


def causes(arguments: argparse.Namespace) -> None:
    from ..effects import BESIDE, catalogue
    from ..report.causes import parameters

    known = parameters()
    if arguments.json:
        found: list[dict[str, Any]] = [
            {
                "cause": key,
                "title": kind.title,
                "sits_at": known[key][0],
                "parameters": [{"name": name, "unit": unit} for name, unit in known[key][1].items()],
            }
            for key, kind in catalogue().items()
        ]
        for key, title in BESIDE.items():
            found.append({"cause": key, "title": title, "sits_at": None, "parameters": []})
        print(json.dumps(found))
        return
    for key, kind in catalogue().items():
        place, params = known[key]
        shown = [f"{name} [{unit}]" if unit else name for name, unit in params.items()][:SHOWN]
        said = ", ".join(shown) + (", ..." if len(params) > SHOWN else "")
        print(f"{key:<22} {kind.title} ({place}: {said})")
    for key, title in BESIDE.items():
        print(f"{key:<22} {title}")
