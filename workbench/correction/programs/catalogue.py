"""All formats: the listing of this folder is the catalogue."""

from __future__ import annotations

import sys
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from ...files.faults import Fault, InputError
from .format import Format


@cache
def formats() -> dict[str, Format]:
    """Every format by name: the classes of format in the modules of this folder."""
    found: dict[str, Format] = {}
    for module in iter_modules(sys.modules[__package__].__path__):
        for member in vars(import_module(f"{__package__}.{module.name}")).values():
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
