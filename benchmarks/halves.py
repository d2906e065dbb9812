"""Whether the same robot, measured again, gets the same names: python benchmarks/halves.py FOLDER [NAME ...]

FOLDER holds campaigns (NAME/campaign.toml) that are read in place. Each is cut into halves, in the order of
measurement and three times at random (a joint position with its loads and repeats stays whole), and both are
diagnosed by themselves; the model.toml of each predicts the other. Where NAME is ONE:OTHER, the model of one
campaign predicts another of the same robot. Default: halves of them all.

Writes `benchmarks/results/halves.json`: what each half names, what it names that the other does not, whether
that is at least among the other's causes or their rivals, and how each is predicted by the other, with its
bounds (`coverage.py`).
"""

import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from blind import git
from coverage import covered

from workbench import Campaign, diagnose, load_campaign
from workbench.diagnosis.result import Diagnosis
from workbench.effects.base import UNKNOWN
from workbench.files.faults import InputError

RESULTS = Path(__file__).resolve().parent / "results/halves.json"
SEEDS = (1, 2, 3)


def halves(campaign: Campaign, seed: int | None) -> tuple[Campaign, Campaign]:
    """Those in the order of measurement, or drawn at random with a seed."""
    position = campaign.poses.positions
    key = np.arange(len(position)) if seed is None else np.random.default_rng(seed).permutation(len(position))
    first = np.full(position.max() + 1, len(key))
    np.minimum.at(first, position, key)
    rank = np.argsort(np.argsort(first))[position]
    one = rank < (position.max() + 1) // 2
    return campaign.some(np.flatnonzero(one)), campaign.some(np.flatnonzero(~one))


def cuts(campaign: Campaign) -> Iterator[tuple[str, tuple[Campaign, Campaign]]]:
    """Its halves, by how it is cut."""
    for seed in (None, *SEEDS):
        yield "in order" if seed is None else f"at random, {seed}", halves(campaign, seed)


def named(found: Diagnosis) -> set[str]:
    return {f.label for f in found.causes if f.status == "named" and f.cause != UNKNOWN}


def said(found: Diagnosis) -> set[str]:
    """Every cause that is reported, or stands beside one that is."""
    rivals = {f"{r.cause}({r.where})".removesuffix("()") for f in found.causes for r in f.rivals}
    return rivals | {f.label for f in found.causes}


def compared(cut: str, pair: tuple[Campaign, Campaign]) -> dict[str, Any]:
    outcomes = [diagnose(half) for half in pair]
    both = [one.diagnosis for one in outcomes]
    names = [named(one) for one in both]
    alone = sorted(names[0] ^ names[1])
    return {
        "cut": cut,
        "held_out_mm": [one.stages[-1].heldout_rms_mm for one in both],
        "named_by_both": sorted(names[0] & names[1]),
        "named_by_one": alone,
        "of_these_said_by_the_other": [n for n in alone if all(n in said(one) for one in both)],
        "predicted": [covered(one, other) for one, other in zip(outcomes, reversed(pair), strict=True)],
    }


def found_in(folder: Path, name: str) -> dict[str, Any]:
    """Of a campaign by halves, or of one that predicts another."""
    one, _, other = name.partition(":")
    campaign = load_campaign(folder / one / "campaign.toml")
    if not other:
        return {"cuts": [compared(*cut) for cut in cuts(campaign)]}
    judge = load_campaign(folder / other / "campaign.toml")
    return {"predicted": covered(diagnose(campaign), judge)}


def main(folder: Path, names: list[str]) -> int:
    names = names or [path.parent.name for path in sorted(folder.glob("*/campaign.toml"))]
    if not names:
        print(f"no campaign.toml in folders of {folder}")
        return 2
    kept = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.is_file() else {}
    for name in names:
        began = time.process_time()
        try:
            found = found_in(folder, name)
        except InputError as error:
            print(f"{name}: {error}", flush=True)
            continue
        kept[name] = {"commit": git("rev-parse", "--short", "HEAD"), **found}
        print(f"{name}: {time.process_time() - began:.0f} s of CPU", flush=True)
        for row in found.get("cuts", [found]):
            print("  " + "; ".join(f"{k} {v}" for k, v in row.items()), flush=True)
        RESULTS.write_text(json.dumps(kept, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
