"""Whether a follow-up settles what a diagnosis left open: faults of the blind study's drawing that come out
ambiguous in a first campaign without payload, the poses that `what_decides` offers, measured in Drake, both
campaigns diagnosed together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ...report.folder import write_together
from ...report.markup import render
from ..blind.cases import FORMS
from ..blind.tally import Rate, rate
from ..case_study import CaseStudy, Record, run_cases
from .case import MOST, run_case

NO_RIVAL = "no rival with a name"


@dataclass(frozen=True)
class FollowUpStudy(CaseStudy):
    """What became of the cases that a first campaign left open."""

    @property
    def open(self) -> list[Record]:
        """Cases that the first campaign left open."""
        return [case for case in self.cases if case["open"]]

    @property
    def followed(self) -> list[Record]:
        """Of these the cases that at most `MOST` poses settle, as is promised."""
        return [case for case in self.cases if case["offered"]]

    @property
    def left_open(self) -> dict[str, int]:
        """Of the open cases that few poses do not settle: how many, by what else would decide them."""
        ways = [", ".join(case["other_ways"]) or NO_RIVAL for case in self.open if not case["offered"]]
        return dict(Counter(ways).most_common())

    @property
    def rates(self) -> list[Rate]:
        cases = self.followed
        return [
            rate("named rightly after one follow-up", cases, _came("right"), at_least=0.9),
            rate("a cause named that is not there", cases, _came("wrong"), at_most=0.0),
            rate("still open", cases, _came("open")),
            rate("λ reached that was said to settle it", cases, _settled),
        ]

    @property
    def kept(self) -> dict[str, float] | None:
        """λ reached over λ promised: the median, and from where to where four of five are."""
        ratios = [
            float(case["lambda_reached"]) / float(case["offered"]["lambda_promised"])
            for case in self.followed
            if case["lambda_reached"] is not None
        ]
        if not ratios:
            return None
        low, middle, high = (float(q) for q in np.quantile(ratios, [0.1, 0.5, 0.9]))
        return {"low": low, "median": middle, "high": high}

    @property
    def text(self) -> str:
        n = len(self.open), len(self.cases), len(self.followed)
        lines = [
            f"{n[1]} cases, seed {self.seed}: {n[0]} left open by the first campaign; "
            f"for {n[2]} of them at most {MOST} poses are said to settle it",
            "",
            *(one.text for one in self.rates),
        ]
        if self.kept is not None:
            said = "{median:.2f} in the median, {low:.2f} to {high:.2f} in four of five".format(**self.kept)
            lines.append(f"{'λ reached over λ promised':<52} {said}")
        return "\n".join(lines + self.broken)

    def to_json(self) -> dict[str, Any]:
        return {
            "schema": 1,
            "seed": self.seed,
            "cases": len(self.cases),
            "open": len(self.open),
            "followed": len(self.followed),
            "rates": [one.to_json() for one in self.rates],
            "lambda_reached_over_promised": self.kept,
            "open_without_few_poses": self.left_open,
            "failed": self.failed,
        }


def _came(what: str) -> Any:
    return lambda case: case["came_of_it"] == what


def _settled(case: Record) -> bool:
    return bool(case["lambda_reached"] and case["lambda_reached"] >= case["offered"]["lambda_needed"])


def case_keys(draws: int) -> list[str]:
    """Keys of a study, all causes in turn, one alone or two."""
    return [f"{cause}/{i}" for i in range(draws) for cause in (*sorted(FORMS), "pair")]


def followup(
    out: Path,
    draws: int = 5,
    seed: int = 0,
    workers: int | None = None,
    resume: bool = False,
    keys: Sequence[str] | None = None,
) -> FollowUpStudy:
    """Runs the study and writes `results.json`, `index.html` and `followup.sqlite` into `out`.

    keys: these cases only. With `resume` cases that are done stay; more draws may be asked for.
    """
    keys = case_keys(draws) if keys is None else keys
    study = run_cases(FollowUpStudy, "followup", run_case, keys, out, seed, workers, resume)
    title = f"Follow-ups: {len(study.followed)} ties, and what one more campaign made of them"
    rows = [_cells(case) for case in study.followed]
    lost = [_cells(case) for case in study.open if not case["offered"]]
    page = render(
        "followup.html",
        title=title,
        text=study.text,
        rows=rows,
        lost=lost,
        version=version("robot-workbench"),
    )
    write_together(out, {"index.html": page, "results.json": study.results})
    return study


def _cells(case: Record) -> tuple[str, ...]:
    """Key, truth, what was left open, what was measured, what was said then, and what came of it."""
    truth = " + ".join(f"{t['label']} λ {t['strength']:.0f}" for t in case["truths"])
    first = str(case["key"]), truth, "; ".join(case["before"])
    if not case["offered"]:
        return first
    way = case["offered"]
    reached = "–" if case["lambda_reached"] is None else f"{case['lambda_reached']:.0f}"
    torque = " with torques" if way["kind"] == "drive_torque" else ""
    said = f"{way['poses']} poses{torque}: λ {way['lambda_before']:.1f} → {way['lambda_promised']:.0f} "
    return (*first, f"{said}promised, {reached} reached", "; ".join(case["after"]), str(case["came_of_it"]))
