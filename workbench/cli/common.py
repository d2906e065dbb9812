"""Options that every command takes, so that a script may give the same to all: where one does nothing that is
said, and the command runs."""

from __future__ import annotations

import argparse
from typing import Any

from .arguments import from_zero, positive
from .status import warn

COMMON: dict[str, dict[str, Any]] = {
    "--seed": {"type": from_zero},
    "--workers": {"type": positive},
    "--resume": {"nargs": 0},
    "--quick": {"nargs": 0},
}


def take_common(parser: argparse.ArgumentParser) -> None:
    """Adds to a command, or to all below it, what it lacks of them; `--help` names only what acts."""
    below = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    for commands in below:
        for command in commands.choices.values():
            take_common(command)
    if below:
        return
    for option, read in COMMON.items():
        if option not in parser._option_string_actions:
            parser.add_argument(option, action=_Idle, dest=argparse.SUPPRESS, help=argparse.SUPPRESS, **read)


class _Idle(argparse.Action):
    """Is taken, and leaves no trace in what is parsed."""

    def __call__(self, parser: argparse.ArgumentParser, _: Any, __: Any, option: str | None = None) -> None:
        warn(f"{option} does nothing in `{parser.prog}`")
