"""Keeps a run of the blind study as the release's figures: python benchmarks/blind.py reports/blind [COMMIT]

Writes `benchmarks/results/blind.json`, which the README quotes, and `workbench/report/reliability.json`,
which the pages draw, both with the commit that the run was made on: HEAD, of a clean checkout, or as given.
"""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks/results/blind.json"
DRAWN = ROOT / "workbench/report/reliability.json"


def git(*words: str) -> str:
    return subprocess.run(
        ["git", *words], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.strip()


def last_lines(failed: dict[str, str]) -> dict[str, str]:
    """Of each traceback the error alone: the rest names files of one machine."""
    return {key: error.strip().splitlines()[-1] for key, error in failed.items()}


def main(folder: Path, commit: str | None = None) -> None:
    if commit is None and git("status", "--porcelain", "workbench"):
        raise SystemExit("the checkout has changes: the figures belong to a commit")
    found = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    on = {"commit": commit or git("rev-parse", "--short", "HEAD")}
    left_out = ("results", "confusion", "schema")
    kept = on | {key: value for key, value in found.items() if key not in left_out}
    kept["failed"] = last_lines(found["failed"])
    few = on | {key: found[key] for key in ("cases", "seed", "reliability")}
    for path, content in {RESULTS: kept, DRAWN: few}.items():
        path.write_text(json.dumps(content, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:3])
