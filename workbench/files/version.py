"""The version of this package."""

from __future__ import annotations

import tomllib
from importlib import metadata
from pathlib import Path

NAME = "robot-workbench"


def version() -> str:
    """As pyproject.toml says in a source tree, newer perhaps than its installation; else as installed."""
    file = Path(__file__).resolve().parents[2] / "pyproject.toml"
    if file.is_file():
        project = tomllib.loads(file.read_text(encoding="utf-8")).get("project", {})
        if project.get("name") == NAME:
            return str(project["version"])
    return metadata.version(NAME)
