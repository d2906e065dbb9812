"""TOML read with its fault told, and made into text."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from .faults import Fault, InputError, read_text


def read_toml(path: Path) -> dict[str, Any]:
    """The content of a TOML file; `InputError` where it is none or cannot be read."""
    try:
        return tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise InputError(Fault(str(path), f"is not TOML: {error}")) from None


def toml_text(table: Mapping[str, Any], comments: Sequence[str] = ()) -> str:
    """The text of a TOML file, with comments on top."""
    lines = [f"# {line}\n" for comment in comments for line in comment.splitlines() or [""]]
    return "".join(lines) + tomli_w.dumps(table)
