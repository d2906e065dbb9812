"""TOML read with its fault told, and made into text."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from .faults import CONTROL, Fault, InputError, counted, read_text
from .measure import beyond

LONGEST = 2000  # characters of a name or a text
SHOWN = 40  # of which a message shows
BARE = re.compile(r"[A-Za-z0-9_-]+")


def read_toml(path: Path) -> dict[str, Any]:
    """The content of a TOML file; `InputError` where it is none or cannot be read."""
    text = read_text(path)
    try:
        content = tomllib.loads(text)
    except ValueError as error:  # TOMLDecodeError, or an integer of thousands of digits
        raise InputError(Fault(str(path), f"is not TOML: {error}")) from None
    except RecursionError:
        raise InputError(Fault(str(path), "is nested too deep", "take brackets out")) from None
    leaves = list(_leaves(content))
    faults = [
        Fault(f"{path}: {place}", f"{text[:SHOWN]!r} {what}", mend)
        for place, text in leaves
        if isinstance(text, str)
        for what, mend in _faults(text)
    ]
    if faults:
        raise InputError(counted(faults))
    huge = [
        Fault(f"{path}: {place}", f"{_number(value)} is beyond all measure", "mend the number")
        for place, value in leaves
        if isinstance(value, int | float) and value == value and beyond(value)  # NaN is the schema's matter
    ]
    if huge:
        raise InputError(counted(huge))
    return content


def _leaves(content: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Every value in a TOML's content, keys too, with its place."""
    if isinstance(content, Mapping):
        for key, value in content.items():
            yield place or "top", key
            yield from _leaves(value, f"{place}.{key[:SHOWN]}" if place else key[:SHOWN])
    elif isinstance(content, Sequence) and not isinstance(content, str):
        for value in content:
            yield from _leaves(value, place)
    else:
        yield place, content


def _number(value: float) -> str:
    """A number in few characters; Python's integers may be too large for `g`."""
    try:
        return f"{value:g}"
    except OverflowError:
        return f"an integer of {len(str(abs(value)))} digits"


def _faults(text: str) -> Iterator[tuple[str, str]]:
    """What is wrong with a text, and how to mend it."""
    if len(text) > LONGEST:
        yield f"... has {len(text)} characters", f"{LONGEST} are enough"
    if CONTROL.search(text):
        yield "has control characters", "take them out"


def toml_key(name: str) -> str:
    """A name as TOML has it as a key or in a table's head: in quotes where it needs them."""
    return name if BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)


def toml_text(table: Mapping[str, Any], comments: Sequence[str] = ()) -> str:
    """The text of a TOML file, with comments on top."""
    lines = [f"# {line}\n" for comment in comments for line in comment.splitlines() or [""]]
    return "".join(lines) + tomli_w.dumps(table)
