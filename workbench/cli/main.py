"""`workbench COMMAND ...`: finds the command and runs it."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import Any, NoReturn

from ..files.faults import plain
from . import (
    check,
    compare,
    compensate,
    demo,
    diagnose,
    export,
    init,
    lists,
    plan,
    predict,
    simulate,
    study,
    verify,
)
from .common import take_common
from .status import guarded

COMMANDS = (
    demo, init, check, diagnose, compare, simulate, plan, compensate, verify, predict, export, study, lists,
)  # fmt: skip


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command; its exit status (`status.guarded`)."""

    def action() -> int | None:
        arguments = command_line().parse_args(argv)
        status: int | None = arguments.run(arguments)
        return status

    return guarded(action)


def command_line() -> argparse.ArgumentParser:
    """All commands with their options; `run` of what is parsed is the command."""
    parser = _Parser(
        prog="workbench",
        description="What a robot's simulation gets wrong, why, and how to draw the right path all the same.",
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="say which version this is")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in COMMANDS:
        module.add(commands)
    take_common(parser)
    return parser


class _Parser(argparse.ArgumentParser):
    """Says what is wrong without what acts in a terminal, and takes -12,0,150 for an option's value; commands
    are parsers of the same kind."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._negative_number_matcher = re.compile(r"^-\.?\d")  # its own knows a single number

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"error: {plain(message)}; see {self.prog} --help\n")


class _Version(argparse.Action):
    """Looks the version up only when it is asked for."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from ..files.version import version

        print(f"workbench {version()}")
        parser.exit()
