"""Our own error rates: robots, campaigns and causes drawn at random, simulated by Drake, diagnosed blind.

One case again: `workbench study case KEY`. Strength of what is hidden is drawn by its
non-centrality λ, not by millimetres, so that every cause is as hard as any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...report.folder import write_together
from ..case_study import CaseStudy, Record, run_cases
from .blind_page import miss_cells, page
from .cases import FORMS
from .plots import figures_of
from .score import run_case
from .tally import Rate, aims, by_cause, by_strength, confusion, figures, missed, reliability
from .unknowns import UNKNOWNS

PAIRS, CLEAN = 3, 4  # cases per draw of two causes, and of clean data with each kind of noise
QUICK = ("backlash", "gear_kinematic_error", "gear_ratio", "joint_compliance", "payload", "thermal_growth")


@dataclass(frozen=True)
class BlindStudy(CaseStudy):
    """What the cases of the blind study come to."""

    @property
    def rates(self) -> list[Rate]:
        return aims(self.cases)

    @property
    def text(self) -> str:
        lines = [f"{len(self.cases)} cases, seed {self.seed}", "", *(r.text for r in self.rates)]
        lines += [*_numbers(self.cases), "", *_strengths(self.cases), "", *_causes(self.cases)]
        return "\n".join(lines + self.broken)

    def to_json(self) -> dict[str, Any]:
        rows, columns, counts = confusion(self.cases)
        return {
            "schema": 1,
            "seed": self.seed,
            "cases": len(self.cases),
            "rates": [r.to_json() for r in self.rates],
            **figures(self.cases),
            "by_strength": by_strength(self.cases),
            "by_cause": by_cause(self.cases),
            "reliability": reliability(self.cases),
            "confusion": {"hidden": rows, "reported": columns, "counts": counts.tolist()},
            "missed": [case["key"] for case in self.cases if missed(case)],
            "failed": self.failed,
        }


def _numbers(cases: Sequence[Record]) -> list[str]:
    said = figures(cases)
    lines = []
    if said["first_by_its_probability"] is not None:
        share = f"{100 * said['first_by_its_probability']:.1f} %"
        lines.append(f"{'λ ≥ 40: first name right, by its own probability':<52} {share:>6}")
    if said["error_over_bound"] is not None:
        error, right = said["error_over_bound"], said["error_over_bound_right_cause"]
        what = "held-out error over the bound, median"
        lines.append(f"{what:<52} {error:.2f} (aim ≤ 1.2), with the right causes {right:.2f}")
    if said["seconds_median"] is not None:
        median, longest = said["seconds_median"], said["seconds_max"]
        lines.append(f"{'seconds per campaign':<52} median {median:.1f}, longest {longest:.1f}")
    return lines


def _strengths(cases: Sequence[Record]) -> list[str]:
    """Shares by λ; best: reported by one who knows the hidden shape."""
    names = ("detected", "reported", "at_best", "first", "named", "wrong")
    heads = ("found", "truth", "best", "first", "named", "wrong")
    lines = [f"{'λ':>12} {'cases':>6}" + "".join(f"{head:>7}" for head in heads)]
    for row in by_strength(cases):
        span = f"{row['from']:g}–" + (f"{row['to']:g}" if row["to"] else "")
        lines.append(f"{span:>12} {row['cases']:>6}" + "".join(f"{100 * row[name]:>7.0f}" for name in names))
    return lines


def _causes(cases: Sequence[Record]) -> list[str]:
    head = f"{'hidden':<24} {'cases':>6} {'first':>6} {'truth':>6} {'wrong':>6} {'unkn.':>6} {'none':>6}"
    names = ("cases", "first_right", "reported", "wrong_name", "unknown", "nothing_missing")
    return [
        head,
        *(f"{row['what']:<24} " + " ".join(f"{row[name]:>6}" for name in names) for row in by_cause(cases)),
    ]


def case_keys(draws: int, quick: bool = False) -> list[str]:
    """Keys of a study, all causes in turn."""
    counts = {cause: draws for cause in sorted(FORMS)}
    counts |= {"pair": PAIRS * draws, "clean-stated": CLEAN * draws, "clean-repeats": CLEAN * draws}
    counts |= {f"unknown-{name}": max(1, draws // 2) for name in UNKNOWNS}
    if quick:
        counts = {cause: 2 for cause in (*QUICK, "pair", "clean-stated", "clean-repeats")}
        counts["unknown-product"] = 1
    return sorted(
        (f"{what}/{i}" for what, count in counts.items() for i in range(count)),
        key=lambda key: (int(key.partition("/")[2]), key),
    )


def blind(
    out: Path,
    draws: int = 20,
    seed: int = 0,
    workers: int | None = None,
    resume: bool = False,
    quick: bool = False,
    keys: Sequence[str] | None = None,
    scheduler: str | None = None,
) -> BlindStudy:
    """Runs the study and writes `results.json`, `index.html`, figures and `blind.sqlite` into `out`.

    keys: these cases only. With `resume` cases that are done stay; more draws may be asked for.
    scheduler: address of a Dask scheduler whose workers do the cases.
    """
    keys = case_keys(draws, quick) if keys is None else keys
    study = run_cases(BlindStudy, "blind", run_case, keys, out, seed, workers, resume, scheduler)
    _write(study)
    return study


def _write(study: BlindStudy) -> None:
    drawn, files = figures_of(study.cases, study.rates)
    misses = [case for case in study.cases if missed(case)]
    title = f"Blind study: {len(study.cases)} cases diagnosed without knowing what is hidden"
    lines = [" | ".join(miss_cells(case)) for case in misses]
    files |= {
        "index.html": page(title, study.text, drawn, misses).encode(),
        "misses.txt": "\n".join([*lines, ""]).encode(),
        "results.json": study.results,
    }
    write_together(study.folder, files)
