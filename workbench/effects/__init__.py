"""The catalogue: one file per cause. A new file with an `Effect` in it is a new cause."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from .base import Effect


@cache
def catalogue() -> dict[str, type[Effect]]:
    """Cause id → class, in the order of the files' names."""
    found: dict[str, type[Effect]] = {}
    for module in pkgutil.iter_modules(__path__):
        if module.name == "base":
            continue
        for value in vars(importlib.import_module(f"{__name__}.{module.name}")).values():
            if isinstance(value, type) and issubclass(value, Effect) and "cause" in vars(value):
                found[value.cause] = value
    return found
