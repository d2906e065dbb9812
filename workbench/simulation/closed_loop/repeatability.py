"""Repeatability of the tool: by the maker's data sheet, and as the stated scatter of the joints makes it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...report.numbers import mm
from ...robot.description import Robot
from ...robot.kinematics import Array, frames
from ...robot.rigid_plant import arrays

DRAWS = 2000


@dataclass(frozen=True)
class Repeatability:
    """ISO 9283 pose repeatability RP of the tool [mm]: by the maker's data sheet, and as the stated scatter
    of the joints makes it at the middle of a path. None: not stated."""

    data_sheet_mm: float | None
    joints_mm: float | None

    @property
    def short(self) -> str:
        """For the place beside a residual: the data sheet's, or that there is none."""
        if self.data_sheet_mm is not None:
            return f"repeatability {mm(self.data_sheet_mm)} mm by data sheet"
        if self.joints_mm is not None:
            return f"repeatability {mm(self.joints_mm)} mm by the joints, no data sheet's"
        return "repeatability not known"

    @property
    def said(self) -> str:
        """Both, as a clause."""
        sheet, joints = self.data_sheet_mm, self.joints_mm
        if sheet is None and joints is None:
            return "repeatability (ISO 9283 RP): not known, neither a data sheet's nor the joints'"
        by_sheet = "not stated" if sheet is None else f"{mm(sheet)} mm"
        by_joints = "not stated" if joints is None else f"{mm(joints)} mm at the tool"
        return f"repeatability (ISO 9283 RP): data sheet {by_sheet}, the joints' own {by_joints}"


def repeatability(robot: Robot, q: Array) -> Repeatability:
    """RP = l̄ + 3 S of the simulated robot on a path with joints q (N, n)."""
    sigma = robot.repeatability
    if not sigma.any():
        return Repeatability(robot.pose_repeatability_mm, None)
    middle = q[len(q) // 2]
    scattered = middle + sigma * np.random.default_rng(0).normal(size=(DRAWS, len(middle)))
    where = frames(arrays(robot), scattered).p[-1]
    away = 1e3 * np.linalg.norm(where - where.mean(axis=0), axis=1)
    return Repeatability(robot.pose_repeatability_mm, float(away.mean() + 3 * away.std(ddof=1)))
