"""An outside judge of `workbench diagnose` on robots with many faults: .../many.py FOLDER [CASES [SEED]]

Three to seven faults at once (`draw_many.py`) in robots of the simulator that `benchmarks/outside` judges by.
λ is what stands out beside geometry and all other faults in their own shapes, which no diagnosis knows. Each
case has its campaign, other poses of the robot, and truth in FOLDER/cases, and a line in FOLDER/results.jsonl
when it is done. Writes `benchmarks/results/many.json` unless the checkout has changes: its figures belong to
a commit.

Rules are those of `score.py`. Missing: a fault with λ ≥ 40 is not in the set; silent: and nothing is said to
be unknown. Bounds: those of `predict` hold at so many points of the other poses, of those where measured.
"""

import sys
from pathlib import Path

from draw_many import draw_many
from runs import MODELS, Json, Run, covered
from score import by_fault, causes, judged, of_probabilities, said_unknown, said_wrongly, says_any
from write import write_case

from workbench import diagnose, load_campaign

CASES, SEED = 60, 20261128
SHOWS = 40.0  # λ


def tables(lines: list[Json]) -> Json:
    """Of all that were diagnosed."""
    silent, nameless = {"missing": 0, "silent": 0}, {"n": 0, "said_unknown": 0}
    for line in lines:
        strong = [fault for fault in line["faults"] if fault["lambda"] >= SHOWS]
        said = [one for cause in causes(line) for one in (cause, *cause["rivals"])]
        missing = any(f["names"] and not any(says_any(c, f["names"]) for c in said) for f in strong)
        silent["missing"] += missing
        silent["silent"] += missing and not said_unknown(line)
        if any(not fault["names"] for fault in strong):
            nameless["n"] += 1
            nameless["said_unknown"] += said_unknown(line)
    of_points = [line["bounds"] for line in lines if line["bounds"]["points"]]
    held = sum(one["points"] * one["held"] for one in of_points) / sum(one["points"] for one in of_points)
    return {
        "faults": by_fault([line | {"faults": [f for f in line["faults"] if f["names"]]} for line in lines]),
        "without_a_name": nameless,
        "of_campaigns": {"n": len(lines), "cause_wrong": sum(map(said_wrongly, lines))} | silent,
        "probability": of_probabilities(lines),
        "bounds": {"points": sum(one["points"] for one in of_points), "held": round(held, 4)},
    }


def main(folder: Path, cases: int = CASES, seed: int = SEED) -> int:
    run = Run.of(folder, seed)

    def done(number: int) -> Json:
        case, other = draw_many(seed, number, folder / "robots", MODELS)
        where = [folder / f"cases/{number:04d}{part}" for part in ("", "-other")]
        truth, _ = write_case(case, where[0]), write_case(other, where[1])
        bounds: Json = {}

        def found() -> Json:
            outcome = diagnose(load_campaign(where[0] / "campaign.toml"))
            bounds.update(covered(outcome, load_campaign(where[1] / "campaign.toml")))
            return judged(outcome.diagnosis.to_json())

        return run.line(truth, found) | {"bounds": bounds}

    def truth(line: Json) -> str:
        return str([(fault["kind"], fault["lambda"]) for fault in line["faults"]])

    lines = run.lines(cases, done, truth)
    found = tables([line for line in lines if "found" in line])
    for name, table in found.items():
        rows = table if isinstance(table, list) else [table]
        print(name, *(f"\n  {row}" for row in rows))
    return run.keep("many.json", lines, found)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), *map(int, sys.argv[2:4])))
