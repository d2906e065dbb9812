"""TOML read with its fault told, and made into text."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from .faults import CONTROL, Fault, InputError, counted, read_text
from .measure import beyond

LONGEST = 2000  # characters of a name or a text
SHOWN = 40  # of which a message shows


def read_toml(path: Path) -> dict[str, Any]:
    """The content of a TOML file; `InputError` where it is none or cannot be read."""
    try:
        content = tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise InputError(Fault(str(path), f"is not TOML: {error}")) from None
    except RecursionError:
        raise InputError(Fault(str(path), "is nested too deep", "take brackets out")) from None
    faults = [
        Fault(f"{path}: {place}", f"{text[:SHOWN]!r} {what}", mend)
        for place, text in _texts(content)
        for what, mend in _faults(text)
    ]
    if faults:
        raise InputError(counted(faults))
    if huge := [Fault(f"{path}: {place}", f"{value:g} is beyond all measure", "mend the number")
                for place, value in _numbers(content) if beyond(value)]:  # fmt: skip
        raise InputError(counted(huge))
    return content


def _numbers(content: Any, place: str = "") -> Iterator[tuple[str, float]]:
    """Every number in a TOML's content with its place; what is no number at all is the schema's matter."""
    if isinstance(content, int | float) and not math.isnan(content):
        yield place, content
    elif isinstance(content, Mapping):
        for key, value in content.items():
            yield from _numbers(value, f"{place}.{key}" if place else key)
    elif isinstance(content, Sequence) and not isinstance(content, str):
        for value in content:
            yield from _numbers(value, place)


def _texts(content: Any, place: str = "") -> Iterator[tuple[str, str]]:
    """Every text in a TOML's content, keys too, with its place."""
    if isinstance(content, str):
        yield place, content
    elif isinstance(content, Mapping):
        for key, value in content.items():
            yield place or "top", key
            yield from _texts(value, f"{place}.{key[:SHOWN]}" if place else key[:SHOWN])
    elif isinstance(content, Sequence):
        for value in content:
            yield from _texts(value, place)


def _faults(text: str) -> Iterator[tuple[str, str]]:
    """What is wrong with a text, and how to mend it."""
    if len(text) > LONGEST:
        yield f"... has {len(text)} characters", f"{LONGEST} are enough"
    if CONTROL.search(text):
        yield "has control characters", "take them out"


def toml_text(table: Mapping[str, Any], comments: Sequence[str] = ()) -> str:
    """The text of a TOML file, with comments on top."""
    lines = [f"# {line}\n" for comment in comments for line in comment.splitlines() or [""]]
    return "".join(lines) + tomli_w.dumps(table)
