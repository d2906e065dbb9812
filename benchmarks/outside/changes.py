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
from collections import Counter
from pathlib import Path

from draw_change import Pair, draw_pair
from runs import MODELS, Json, Run
from score import BANDS, band, says_any
from write import plain, write_case

from workbench import compare

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


def main(folder: Path, pairs: int = PAIRS, seed: int = SEED) -> int:
    run = Run.of(folder, seed)

    def done(number: int) -> Json:
        pair = draw_pair(seed, number, folder / "robots", MODELS)
        truth = {"case": number} | json.loads(json.dumps(pair.truth, default=plain))
        return run.line(truth, lambda: compared(pair, folder / "cases"))

    def truth(line: Json) -> str:
        return f"{line['kind']} {line.get('names', '')} {line.get('lambda', '')}"

    lines = run.lines(pairs, done, truth)
    found = tables([line for line in lines if "found" in line])
    for name, table in found.items():
        print(name, *(f"\n  {key}: {counts}" for key, counts in table.items()))
    return run.keep("changes.json", lines, found)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), *map(int, sys.argv[2:4])))
