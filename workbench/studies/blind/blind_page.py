"""The study's page: rates, figures, and every case that went wrong, with the key that repeats it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version

from ...report.drawing import Figure
from ...report.markup import render
from ..case_study import Record


def page(title: str, text: str, figures: Sequence[Figure], misses: Sequence[Record]) -> str:
    """The whole page."""
    rows = [miss_cells(case) for case in misses]
    made = version("robot-workbench")
    return render("blind.html", title=title, text=text, figures=figures, misses=rows, version=made)


def miss_cells(case: Record) -> tuple[str, str, str, str]:
    """Key, set-up, truth and what was said. [λ x]: of the truth, that a cause alone would leave."""
    setup = (
        f"{case['robot']} {case['records']}×{case['targets']} {case['noise']} "
        f"{1e3 * case['sigma_mm']:.0f} µm{', two loads' if case['loads'] > 1 else ''}"
    )
    truth = " + ".join(f"{t['label']} λ {t['strength']:.0f}" for t in case["truths"]) or "nothing"
    if case["form_left"] is not None and case["unknown_mm"] is None:
        truth += f" (form leaves {case['form_left']:.1f})"
    said = "; ".join(_said(f) for f in case["found"]) or "nothing"
    faults = f" FAULTS {', '.join(case['faults'])}" if case["faults"] else ""
    return str(case["key"]), setup, truth, f"{case['verdict']}: {said}{faults}"


def _said(finding: Record) -> str:
    text = f"{finding['label']} {finding['status']}"
    if "left" in finding:
        text += f" [{finding['left']:.1f}]"
    if finding["rivals"]:
        text += f" or {', '.join(finding['rivals'])}"
    return text
