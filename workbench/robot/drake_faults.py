"""What Drake finds wrong with a URDF, as a fault of the file: its line, in one sentence."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager

from ..files.faults import BUILD, Fault, InputError
from .description import Robot

PLACED = re.compile(r"[^\s:]*:(\d+): (?:error: )?(.*)", re.DOTALL)  # file:line: error: what


@contextmanager
def drake_reads(robot: Robot) -> Iterator[None]:
    """While Drake parses the robot's URDF: its exceptions become `InputError`."""
    reversed_limits = [
        Fault(
            f"{robot.urdf}: joint {j.name!r}",
            f"limits from {j.lower:g} to {j.upper:g}",
            "exchange lower and upper",
        )
        for j in robot.joints
        if j.lower > j.upper  # would end the process in there
    ]
    if reversed_limits:
        raise InputError(reversed_limits)
    log, told = logging.getLogger("drake"), _Told()
    log.addFilter(told)
    try:
        yield
    except (RuntimeError, ValueError) as error:
        text = BUILD.sub("", str(error))
        placed = PLACED.match(text)
        place = f"{robot.urdf} line {placed[1]}" if placed else str(robot.urdf)
        what = " ".join((placed[2] if placed else text).split())
        raise InputError(Fault(place, f"Drake cannot read it: {what}", "mend the URDF")) from None
    finally:
        log.removeFilter(told)


@contextmanager
def quiet() -> Iterator[None]:
    """While Drake would remark on what is usual here: warnings only."""
    log = logging.getLogger("drake")
    level = log.level
    log.setLevel(logging.WARNING)
    try:
        yield
    finally:
        log.setLevel(level)


class _Told(logging.Filter):
    """What Drake remarks, without its own source files."""

    def filter(self, record: logging.LogRecord) -> bool:
        record.msg, record.args = BUILD.sub("", record.getMessage()), ()
        return True
