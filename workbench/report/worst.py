"""The poses that the found model fits worst, by name: where to look first, or to measure once more."""

from __future__ import annotations

import numpy as np

from ..diagnosis.result import Diagnosis
from .figures import SELDOM, before_of, norm_mm
from .numbers import mm
from .residuals import called

LISTED = 5


def worst_poses(diagnosis: Diagnosis) -> list[list[str]]:
    """A row per pose, the worst first: its name, its worst target, that target's 3-D error [mm] before and
    after. Nothing where the errors are not known."""
    errors = diagnosis.errors
    if errors is None or not len(errors.pose):
        return []
    before, after = before_of(diagnosis, errors)[0], norm_mm(errors.error_final)
    worst: dict[int, int] = {}  # pose → its worst point
    for point in np.argsort(-after, kind="stable"):
        worst.setdefault(int(errors.pose[point]), int(point))
    rows = []
    for point in list(worst.values())[:LISTED]:
        rows.append([*called(errors, point), mm(float(before[point])), mm(float(after[point]))])
    return rows


def worst_head(diagnosis: Diagnosis) -> list[str]:
    """What its columns are."""
    before = "" if diagnosis.errors is None else before_of(diagnosis, diagnosis.errors)[1]
    return ["Pose", "Worst target", f"{before[:1].upper()}{before[1:]}, mm", "After, mm"]


def worst_said(diagnosis: Diagnosis) -> str:
    """What the noise alone would make of it."""
    sigma = diagnosis.noise.alone_mm
    if diagnosis.noise.source == "residual" or not sigma > 0:
        return "3-D errors of the worst target of each pose."
    seldom = mm(SELDOM * sigma)
    return f"3-D errors of the worst target of each pose; noise alone makes seldom more than {seldom} mm."
