"""How often a cause is named by its λ beside its hardest rival: python benchmarks/power.py [DRAWS] [COMMIT]

Faults of the blind study's drawing, each in the sizes that give it a λ of 20, 40 and 80 beside the cause
that imitates it best, measured in Drake and diagnosed. Writes `benchmarks/results/power.json`, the figures
of `workbench.measurement.design.discrimination_plan.LEVELS`. Faults that no size tells from a rival, or only
one that no robot has, are left out.
"""

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from blind import git

from workbench import diagnose, simulate
from workbench.studies.blind.cases import FORMS, Case, draw_case, true_robot
from workbench.studies.blind.score import key_of
from workbench.studies.blind.sight import planned_for
from workbench.studies.blind.tally import rate

RESULTS = Path(__file__).resolve().parent / "results/power.json"
LEVELS = (20.0, 40.0, 80.0)
TWIN = 0.02  # share of λ alone that a rival leaves: below, no size tells them apart
SEED = 7


def hardest(case: Case) -> float:
    """λ that the cause which imitates best leaves of what is hidden."""
    assert case.products is not None
    others = [k for key, k in case.products.keys().items() if key not in case.truths]
    return min(case.strength[0], *(case.products.left(k) for k in others))


def diagnosed(case: Case, level: float, now: float) -> dict[str, object] | None:
    """What is named where the fault has a λ of `level` beside its hardest rival; None: no robot has it."""
    sizes = [case.sizes[0] * (level / now) ** 0.5]
    if sizes[0] > case.hidden[0].largest:
        return None
    plan = planned_for(case.design.plan, case.hidden, sizes)
    truth = true_robot(case.design, case.hidden, sizes)
    outcome = diagnose(simulate(plan, truth, seed=SEED, state_sigma=case.design.stated))
    named = {key_of(f) for f in outcome.diagnosis.causes if f.status == "named" and f.cause != "unknown"}
    truths = set(case.truths)
    return {"key": case.key, "level": level, "right": truths <= named, "wrong": bool(named - truths)}


def main(draws: int, commit: str | None = None) -> None:
    records: list[dict[str, object]] = []
    for key in (f"{cause}/{i}" for i in range(draws) for cause in sorted(FORMS)):
        with TemporaryDirectory() as folder:
            case = draw_case(key, SEED, Path(folder))
            now = hardest(case)
            if now > TWIN * case.strength[0]:
                records += filter(None, (diagnosed(case, level, now) for level in LEVELS))
        RESULTS.write_text(json.dumps(figures(records, commit), indent=1) + "\n", encoding="utf-8")
        print(key, len(records), flush=True)


def figures(records: list[dict[str, object]], commit: str | None) -> dict[str, object]:
    """Per level how many were named rightly, and wrongly."""
    levels = []
    for level in LEVELS:
        here = [one for one in records if one["level"] == level]
        right = rate("named rightly", here, lambda one: bool(one["right"]))
        wrong = rate("a cause named that is not there", here, lambda one: bool(one["wrong"]))
        levels.append({"lambda": level, "right": right.to_json(), "wrong": wrong.to_json()})
    return {"commit": commit or git("rev-parse", "--short", "HEAD"), "seed": SEED, "levels": levels}


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3, *sys.argv[2:3])
