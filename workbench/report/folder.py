"""The files of one result: made first, then written together."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..files.whole import put_all


def write_together(files: Mapping[Path, bytes]) -> tuple[Path, ...]:
    """Write the files of one result, all or none; their paths. The folders they stand in are made."""
    put_all(files)
    return tuple(files)


def json_bytes(data: Mapping[str, Any]) -> bytes:
    """A JSON file for people and programs."""
    return (json.dumps(data, indent=2, ensure_ascii=False) + "\n").encode()
