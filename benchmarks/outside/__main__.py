"""An outside judge of `workbench diagnose`: python benchmarks/outside FOLDER [CASES [SEED]]

A robot simulator that was written without reading the program: own kinematics, gravity, elastic joints and
faults, each a little off its textbook form, and own rules of what is right (`score.py`). Of `workbench` it
imports nothing but `load_campaign` and `diagnose`, and these here alone; what it measures reaches them as a
campaign's files. The project's models are read as files too; ten more robots are made in code.

Each case has its campaign and truth in FOLDER/cases, and a line in FOLDER/results.jsonl when it is done: what
was done before, by the same seed on the same commit, is not done again. Writes
`benchmarks/results/outside.json` unless the checkout has changes: its figures belong to a commit.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[1]))  # for blind.py, behind this folder

from blind import git
from draw import draw
from robots import write_robots
from runs import MODELS, ROOT, done_before
from score import print_tables, tables
from write import write_case

from workbench import diagnose, load_campaign

RESULTS = ROOT / "benchmarks/results/outside.json"
CASES = 480
SEED = 20261122
KEPT = ("cause", "joint", "other", "link", "payload", "order", "status", "probability")


def said(cause: dict[str, Any]) -> dict[str, Any]:
    """A cause or a rival, as far as it is judged."""
    return {key: cause[key] for key in KEPT if cause.get(key) not in (None, "")}


def diagnosed(campaign: Path) -> dict[str, Any]:
    """What is judged of a diagnosis."""
    found = diagnose(load_campaign(campaign)).diagnosis.to_json()
    causes = [
        said(cause) | {"rivals": [said(rival) for rival in cause["rivals"]]} for cause in found["causes"]
    ]
    faults = sorted({fault["kind"] for fault in found["faults"]})
    return {"verdict": found["verdict"], "headline": found["headline"], "causes": causes, "faults": faults}


def done(number: int, folder: Path, run: dict[str, Any]) -> dict[str, Any]:
    """A case drawn, written and diagnosed; a diagnosis that fails is kept with its error."""
    where = folder / f"cases/{number:04d}"
    line = run | write_case(draw(run["seed"], number, folder / "robots", MODELS), where)
    began = time.process_time()
    try:
        line["found"] = diagnosed(where / "campaign.toml")
    except Exception as error:
        line["failed"] = f"{type(error).__name__}: {error}"
    return line | {"cpu_s": round(time.process_time() - began, 2)}


def main(folder: Path, cases: int = CASES, seed: int = SEED) -> int:
    changed = git("status", "--porcelain", "workbench", "models", "benchmarks/outside")
    run = {"seed": seed, "commit": git("rev-parse", "--short", "HEAD") + ("+" if changed else "")}
    path = folder / "results.jsonl"
    lines = done_before(path, run)
    write_robots(MODELS, folder / "robots")
    for number in range(cases):
        if number in lines:
            continue
        line = lines[number] = done(number, folder, run)
        with open(path, "a", encoding="utf-8") as file:
            file.write(json.dumps(line, ensure_ascii=False) + "\n")
        truth = [(fault["kind"], fault["lambda"]) for fault in line["faults"]]
        answer = line["found"]["headline"] if "found" in line else line["failed"]
        print(f"{number} {line['robot']} {line['sort']} {truth}: {answer} ({line['cpu_s']} s)", flush=True)
    judged = [lines[number] for number in range(cases)]
    found = tables([line for line in judged if "found" in line])
    print_tables(found)
    failed = {line["case"]: line["failed"].split(":")[0] for line in judged if "failed" in line}
    if changed:
        print(f"not written to {RESULTS.name}: the checkout has changes")
    else:
        kept = {"commit": run["commit"], "seed": seed, "cases": cases, "failed": failed, **found}
        RESULTS.write_text(json.dumps(kept, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), *map(int, sys.argv[2:4])))
