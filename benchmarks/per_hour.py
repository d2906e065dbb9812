"""What choosing all factors of a plan together is worth: python benchmarks/per_hour.py [STATES] [COMMIT]

Information per hour of `plan --minutes` over that of random poses, and over that of the best poses alone (no
load, no stops on the way, all targets), for robots of the blind study's drawing: nothing measured yet or a
first campaign of 24 unloaded poses; asked for accuracy, or to tell a cause from what imitates it best
of what can be told.
Loads are the drawn ones; a pull as heavy as the heaviest of them can be rigged. Writes
`benchmarks/results/per_hour.json` after every state.
"""

import json
import sys
from dataclasses import replace
from itertools import count, islice
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from blind import git

from workbench import Campaign, Robot, plan
from workbench.campaign.cell import CellData, DrivingData
from workbench.files.faults import InputError
from workbench.measurement.design.accuracy_plan import AccuracyPlan
from workbench.measurement.design.discrimination_plan import DiscriminationPlan
from workbench.robot.schema import LoadData
from workbench.studies.blind.cases import FORMS, Case, draw_case
from workbench.studies.blind.sight import Key
from workbench.studies.followup.case import first_campaign

RESULTS = Path(__file__).resolve().parent / "results/per_hour.json"
SEED = 11
MINUTES = 20.0
TWIN = 0.02  # share of λ alone that a rival leaves: below, no poses tell them apart
TELLS = 1.0  # λ below which a plan tells nothing, so that there is nothing to compare
RIVALS = 4  # that are asked for, the best imitation first, until a plan tells one
GRAVITY = 9.81


def questions(case: Case) -> list[str]:
    """What is hidden beside each of what imitates it best, as `--tell` takes them, without twins."""
    assert case.products is not None
    others = {key: case.products.left(k) for key, k in case.products.keys().items() if key not in case.truths}
    rivals = sorted((key for key in others if others[key] > TWIN * case.strength[0]), key=others.__getitem__)
    return [f"{said(case.truths[0])},{said(rival)}" for rival in rivals[:RIVALS]]


def said(key: Key) -> str:
    """A cause and its place as `--tell` takes them."""
    cause, where = key
    return f"{cause}:" + ",".join(f"{k}={v}" for k, v in where.keys().items())


def source(case: Case, measured: bool) -> Campaign | Robot:
    """The first campaign, or the robot with the loads that are there."""
    c = case.campaign
    if measured:
        return first_campaign(c)
    loads = zip(c.payload_names[1:], c.load_mass[1:], c.load_com[1:], strict=True)
    return replace(
        c.robot,
        payloads={
            name: LoadData(mass_kg=float(mass), com_mm=tuple(float(1e3 * v) for v in com))
            for name, mass, com in loads
        },
    )


def state(key: str, measured: bool, tell: bool) -> dict[str, object] | None:
    """Both figures for one robot; None where no plan of that time tells its cause from another."""
    with TemporaryDirectory() as folder:
        case = draw_case(key, SEED, Path(folder))
        heaviest = float(case.campaign.load_mass.max())
        cell = CellData(driving=DrivingData(pull_N=GRAVITY * heaviest if heaviest > 0 else None))
        known = source(case, measured)
        for asked in questions(case) if tell else [None]:
            try:
                made = plan(known, tell=asked, minutes=MINUTES, cell=cell, seed=SEED)
            except InputError:  # the campaign has no such column, or it takes longer
                continue
            if made.drive is not None and getattr(made, "least", TELLS) >= TELLS:
                about = {"key": key, "robot": case.robot, "measured": measured, "tell": asked}
                return {**about, **facts(made)}
    return None


def facts(made: AccuracyPlan | DiscriminationPlan) -> dict[str, object]:
    """Both figures, and what was chosen."""
    assert made.drive is not None
    return {
        "over_random": made.gain,
        "over_poses_alone": made.over_poses,
        "minutes": made.drive.total_s / 60,
        "records": len(made.drive.own.poses),
        "stops": made.stops,
        "blocks": [block.name for block in made.drive.blocks],
        "targets": made.drive.targets,
        "left_out": list(made.skipped),
    }


def main(states: int, commit: str | None = None) -> None:
    found: list[dict[str, object]] = []
    keys = (f"{cause}/{i}" for i in count() for cause in sorted(FORMS))
    for n, key in enumerate(islice(keys, 2 * states)):
        one = state(key, measured=n % 2 == 1, tell=n % 4 >= 2)
        if one is not None:
            found.append(one)
            RESULTS.write_text(json.dumps(figures(found, commit), indent=1) + "\n", encoding="utf-8")
            print(one, flush=True)
        if len(found) == states:
            break


def figures(found: list[dict[str, object]], commit: str | None) -> dict[str, object]:
    """Medians; None, where random poses or poses alone never reach it, is more than any number."""
    medians = {
        name: float(np.median([np.inf if one[name] is None else float(str(one[name])) for one in found]))
        for name in ("over_random", "over_poses_alone")
    }
    commit = commit or git("rev-parse", "--short", "HEAD")
    return {"commit": commit, "seed": SEED, "minutes": MINUTES, "median": medians, "states": found}


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20, *sys.argv[2:3])
