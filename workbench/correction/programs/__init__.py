"""Robot programs in the controllers' own formats. One file per format; the listing is the catalogue."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from ...files.faults import Fault, InputError
from ...robot.description import Robot
from . import files as _files
from .base import Array, Program
from .files import LEAST_MM, RoundingEffect
from .format import Format
from .measuring import DWELL_S, measured
from .measuring import measuring_program as _measuring_program
from .shown import as_shown, as_urdf
from .thin import thinned

__all__ = [
    "LEAST_MM",
    "Format",
    "Program",
    "RoundingEffect",
    "as_shown",
    "as_urdf",
    "find_format",
    "formats",
    "measured",
    "measuring_program",
    "read_program",
    "rounding_effect",
    "thinned",
    "write_program",
]


@cache
def formats() -> dict[str, Format]:
    """Every format by name: the classes of format in the modules of this folder."""
    found: dict[str, Format] = {}
    for module in iter_modules(__path__):
        for member in vars(import_module(f"{__name__}.{module.name}")).values():
            if isinstance(member, type) and issubclass(member, Format) and "name" in vars(member):
                found[member.name] = member()
    return dict(sorted(found.items()))


def find_format(name: str) -> Format:
    """The format of that name; `InputError` with the names that there are."""
    try:
        return formats()[name]
    except KeyError:
        raise InputError(
            Fault(f"format {name!r}", "no such format", f"one of {', '.join(formats())}")
        ) from None


def write_program(program: Program, format: str | Format, out: Path | str, keep: bool = False) -> list[Path]:
    """Writes a program for a controller, all files or none; see `files.write_program`."""
    chosen = find_format(format) if isinstance(format, str) else format
    return _files.write_program(program, chosen, Path(out), keep)


def read_program(path: Path | str, format: str | Format) -> Program:
    """Reads a controller's program; see `files.read_program`."""
    return _files.read_program(Path(path), find_format(format) if isinstance(format, str) else format)


def rounding_effect(
    program: Program,
    format: str | Format,
    forward: Callable[[Array], Array] | None = None,
    lever: float = 0.0,
) -> RoundingEffect:
    """What writing in this format does at the tool; see `files.rounding_effect`."""
    chosen = find_format(format) if isinstance(format, str) else format
    return _files.rounding_effect(program, chosen, forward, lever)


def measuring_program(
    robot: Robot, q: Array, format: str | Format, dwell_s: float = DWELL_S, **options: Any
) -> Program:
    """A program that brings the arm to poses to be measured; see `measuring.measuring_program`."""
    chosen = find_format(format) if isinstance(format, str) else format
    return _measuring_program(robot, q, chosen, dwell_s, **options)
