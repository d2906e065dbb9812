"""Where the judges find and keep what they need."""

import json
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
MODELS = ROOT / "models"


def done_before(path: Path, run: dict[str, Any]) -> dict[int, dict[str, Any]]:
    """The lines of an earlier run, by case."""
    if not path.is_file():
        return {}
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    if any({key: line[key] for key in run} != run for line in lines):
        raise SystemExit(f"{path} is of another seed or commit: give another folder")
    return {line["case"]: line for line in lines}
