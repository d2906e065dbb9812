"""An outside judge of `workbench compare`: python benchmarks/outside/changes.py FOLDER [PAIRS [SEED]]

Pairs of campaigns of the simulator that `benchmarks/outside` judges `diagnose` with (`draw_change.py`). Each
has its files in FOLDER/cases, and a line in FOLDER/results.jsonl when it is done. Writes
`benchmarks/results/changes.json` unless the checkout has changes: its figures belong to a commit.

Told: the exit status is right. Possible: a change of the robot is said, but not for sure. In set: the change
is said, or stands among the rivals of one that is; first: it is said. Targets: it is right whether they were
mounted anew. Wrong name: a change of the robot has the status "named" and is neither what was made nor a fair
twin of it. A change of geometry is right where its joint is.
"""

import json
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[1]))  # for blind.py, behind this folder

from blind import git
from draw_change import Pair, draw_pair
from robots import write_robots
from runs import MODELS, ROOT, done_before
from score import BANDS, Json, band, says_any
from write import write_case

from workbench import compare

RESULTS = ROOT / "benchmarks/results/changes.json"
PAIRS, SEED = 240, 20261124
KEPT = ("what", "cause", "joint", "other", "link", "order", "side", "status", "probability", "moves_mm")


def said(change: Json) -> Json:
    return {key: change[key] for key in KEPT if change.get(key) not in (None, "")}


def compared(pair: Pair, folder: Path) -> Json:
    """What is judged of a comparison."""
    cases = (pair.before, pair.after)
    places = [folder / f"{pair.truth['pair']:04d}-{name}" for name in ("before", "after")]
    for case, place in zip(cases, places, strict=True):
        write_case(case, place)
    found = compare([place / "campaign.toml" for place in places])
    told = found.to_json()
    changes = [
        said(change) | {"rivals": [said(rival) for rival in change["rivals"]]} for change in told["changes"]
    ]
    moved = any(one["targets_moved"] for one in told["apart"][1:])
    return {"exit": found.exit_status, "headline": found.headline, "changes": changes, "targets_moved": moved}


def tables(lines: list[Json]) -> Json:
    """By kind, and of changes by band of λ."""
    kinds: dict[str, Counter] = {}
    bands = {name: Counter() for _, name in BANDS}
    for line in lines:
        found, right = line["found"], line.get("names", [])
        told = (found["exit"] == 3) == line["changed"]
        named = [c for c in found["changes"] if c["status"] == "named" and c["side"] == "robot"]
        wrong = any(not says_any(c, right + line.get("twins", [])) for c in named)
        possible = any(c["status"] == "possible" and c["side"] == "robot" for c in found["changes"])
        targets = found["targets_moved"] == line["remounted"]
        counts = {"n": 1, "told": told, "possible": possible, "wrong_name": wrong, "targets": targets}
        if line["changed"]:
            every = [one for c in found["changes"] for one in (c, *c["rivals"])]
            counts["in_set"] = any(says_any(c, right) for c in every)
            counts["first"] = any(says_any(c, right) for c in found["changes"])
            counts["named"] = any(says_any(c, right) for c in named)
            bands[band(line["lambda"])].update(counts)
        kinds.setdefault(line["kind"], Counter()).update(counts)
    return {
        name: {key: {k: int(n) for k, n in counts.items()} for key, counts in table.items() if counts}
        for name, table in (("by_kind", kinds), ("by_lambda", bands))
    }


def done(number: int, folder: Path, run: Json) -> Json:
    """A pair drawn, written and compared; a comparison that fails is kept with its error."""
    pair = draw_pair(run["seed"], number, folder / "robots", MODELS)
    line: dict[str, Any] = run | {"case": number} | json.loads(json.dumps(pair.truth, default=_plain))
    began = time.process_time()
    try:
        line["found"] = compared(pair, folder / "cases")
    except Exception as error:
        line["failed"] = f"{type(error).__name__}: {error}"
    return line | {"cpu_s": round(time.process_time() - began, 2)}


def _plain(value: Any) -> Any:
    return value.tolist()


def main(folder: Path, pairs: int = PAIRS, seed: int = SEED) -> int:
    changed = git("status", "--porcelain", "workbench", "models", "benchmarks/outside")
    run = {"seed": seed, "commit": git("rev-parse", "--short", "HEAD") + ("+" if changed else "")}
    path = folder / "results.jsonl"
    lines = done_before(path, run)
    write_robots(MODELS, folder / "robots")
    for number in range(pairs):
        if number in lines:
            continue
        line = lines[number] = done(number, folder, run)
        with open(path, "a", encoding="utf-8") as file:
            file.write(json.dumps(line, ensure_ascii=False) + "\n")
        answer = line["found"]["headline"] if "found" in line else line["failed"]
        truth = f"{line['kind']} {line.get('names', '')} {line.get('lambda', '')}"
        print(f"{number} {line['robot']} {truth}: {answer} ({line['cpu_s']} s)", flush=True)
    judged = [lines[number] for number in range(pairs)]
    found = tables([line for line in judged if "found" in line])
    failed = {line["case"]: line["failed"].split(":")[0] for line in judged if "failed" in line}
    for name, table in found.items():
        print(name, *(f"\n  {key}: {counts}" for key, counts in table.items()))
    if changed:
        print(f"not written to {RESULTS.name}: the checkout has changes")
    else:
        kept = {"commit": run["commit"], "seed": seed, "pairs": pairs, "failed": failed, **found}
        RESULTS.write_text(json.dumps(kept, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), *map(int, sys.argv[2:4])))
