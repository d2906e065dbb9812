"""Keeps a run of the follow-up study as figures: python benchmarks/followup.py reports/followup [COMMIT]

Writes `benchmarks/results/followup.json`, which the README quotes, with the commit that the run was made on.
"""

import json
import sys
from pathlib import Path

from blind import git, last_lines

from workbench.studies.followup import FollowUpStudy

RESULTS = Path(__file__).resolve().parent / "results/followup.json"
SHOWN = ("key", "offered", "before", "after", "lambda_reached", "came_of_it")


def main(folder: Path, commit: str | None = None) -> None:
    if commit is None and git("status", "--porcelain", "workbench"):
        raise SystemExit("the checkout has changes: the figures belong to a commit")
    found = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    study = FollowUpStudy(folder, found["seed"], tuple(found["results"]), last_lines(found["failed"]))
    cases = [{name: case[name] for name in SHOWN} for case in study.followed if case["came_of_it"] != "right"]
    kept = {"commit": commit or git("rev-parse", "--short", "HEAD"), **study.to_json(), "not_right": cases}
    RESULTS.write_text(json.dumps(kept, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:3])
