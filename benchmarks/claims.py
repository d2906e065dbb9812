"""Runs published studies quickly under ten seeds: python benchmarks/claims.py reports/claims [SEEDS [NAME..]]

Says of every claim in how many seeds it holds and is said, and puts it into `benchmarks/results/claims.json`
with the faults that `workbench.studies.seeds` finds. What was run under a seed is read, not run again.
`read.txt` beside the runs lists the sentences that compare and are said under every seed, for a reader.
"""

import json
import subprocess
import sys
import time
from pathlib import Path

from workbench.studies import PUBLISHED, seeds
from workbench.studies.running import run_published
from workbench.studies.study_run import StudyRun

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks/results/claims.json"
STUDIES = ROOT / "workbench/studies"


def page(folder: Path, name: str, seed: int) -> seeds.Page:
    where = folder / str(seed) / name
    if not (where / "result.json").is_file():
        began = time.process_time()
        run_published((name,), StudyRun(where, seed=seed, quick=True, workers=1, resume=True))
        print(f"{name}, seed {seed}: {time.process_time() - began:.0f} s of CPU", flush=True)
    return seeds.read_page(where)


def main(folder: Path, count: int, names: tuple[str, ...]) -> int:
    pages = {name: [page(folder, name, seed) for seed in range(count)] for name in names}
    stories = {name: (STUDIES / name / "story.md").read_text(encoding="utf-8") for name in names}
    faults = {name: seeds.faults(stories[name], pages[name]) for name in names}
    claims = {name: seeds.claims_of(pages[name]) for name in names}
    for name in names:
        print(f"\n{name}: holds in, said in, of {count} seeds; share of all draws")
        for key, one in claims[name].items():
            counts = f"{one['holds']:3} {one['said']:3}  {one['share']:6.1%} of {one['draws']:6}"
            print(f"  {counts}  {key}: {one['words']}")
        print(*(f"  FAULT {fault}" for fault in faults[name]), sep="\n")
    read = [f"{name}: {sentence}" for name in names for sentence in seeds.to_read(pages[name])]
    (folder / "read.txt").write_text("\n".join(read) + "\n", encoding="utf-8")
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.strip()
    kept = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.is_file() else {}
    for name in names:
        kept[name] = {"commit": commit, "seeds": count, "claims": claims[name], "faults": faults[name]}
    RESULTS.write_text(json.dumps(kept, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    return int(any(faults.values()))


if __name__ == "__main__":
    given = sys.argv[3:] or PUBLISHED
    sys.exit(main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 10, tuple(given)))
