"""Robot programs in the controllers' own formats. One file per format; the listing is the catalogue."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from ...files.faults import Fault, InputError
from .base import Program
from .files import LEAST_MM, RoundingEffect, rounding_effect, write_program
from .format import Format
from .measuring import measuring_program
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
    "measuring_program",
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
