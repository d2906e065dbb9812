"""The files of one result: made first, then written together."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..files.whole import put_all


def write_together(folder: Path, files: Mapping[str, bytes | str]) -> tuple[Path, ...]:
    """Write the files of one result, by their names in the folder, all or none; their paths."""
    placed = {folder / name: data for name, data in files.items()}
    put_all(placed)
    return tuple(placed)


def json_bytes(data: Mapping[str, Any]) -> bytes:
    """A JSON file for people and programs."""
    return (json.dumps(data, indent=2, ensure_ascii=False) + "\n").encode()
