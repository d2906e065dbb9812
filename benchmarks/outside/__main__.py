"""An outside judge of `workbench diagnose`: python benchmarks/outside FOLDER [CASES [SEED]]

A robot simulator that was written without reading the program: own kinematics, gravity, elastic joints and
faults, each a little off its textbook form, and own rules of what is right (`score.py`). Of `workbench` it
imports nothing but `load_campaign` and `diagnose`, and these here alone; what it measures reaches them as a
campaign's files. The project's models are read as files too; ten more robots are made in code.

Each case has its campaign and truth in FOLDER/cases, and a line in FOLDER/results.jsonl when it is done: what
was done before, by the same seed on the same commit, is not done again. Writes
`benchmarks/results/outside.json` and `workbench/report/outside.json`, which pages draw, unless the checkout
has changes: its figures belong to a commit.
"""

import sys
from pathlib import Path
from typing import Any

from draw import draw
from runs import MODELS, Run
from score import judged, print_tables, tables
from write import write_case

from workbench import diagnose, load_campaign

CASES = 480
SEED = 20261122


def main(folder: Path, cases: int = CASES, seed: int = SEED) -> int:
    run = Run.of(folder, seed)

    def done(number: int) -> dict[str, Any]:
        where = folder / f"cases/{number:04d}"
        truth = write_case(draw(seed, number, folder / "robots", MODELS), where)
        return run.line(
            truth, lambda: judged(diagnose(load_campaign(where / "campaign.toml")).diagnosis.to_json())
        )

    def truth(line: dict[str, Any]) -> str:
        return f"{line['sort']} {[(fault['kind'], fault['lambda']) for fault in line['faults']]}"

    lines = run.lines(cases, done, truth)
    found = tables([line for line in lines if "found" in line])
    print_tables(found)
    return run.keep("outside.json", lines, found, drawn=("probability",))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), *map(int, sys.argv[2:4])))
