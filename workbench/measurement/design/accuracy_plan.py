"""Records for accuracy, and what the calibrated model errs by after them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ...campaign import Campaign
from ...report.numbers import mm
from ..driving.block import Drive
from .candidates import payload_counts
from .driven_plan import DrivenPlan

MOST_TRIED = 100  # times the plan's number of random poses that are tried


@dataclass(frozen=True)
class AccuracyPlan(DrivenPlan):
    """Records for accuracy, in the order to measure them, and the expected errors [mm]: one sigma, 3-D, of
    the model's prediction from noise alone. now_mm: from the campaign (None: there is none); random_mm: the
    median after as many random records; same: random records for the error of this plan (None: more than
    `MOST_TRIED` times as many); random: as many random records; random_s: of as many as reach this plan's
    error."""

    records: Campaign
    noise: str
    now_mm: float | None
    random_mm: float
    plan_mm: float
    same: int | None
    random: Campaign

    @property
    def gain(self) -> float | None:
        """Information per hour over that of random records: their time for the same error by the plan's."""
        if self.drive is None or self.random_s is None:
            return None
        return self.random_s / self.drive.total_s

    def with_drive(self, drive: Drive, random: Drive) -> AccuracyPlan:
        """In the order of a drive; random: that of as many random records."""
        each = (random.moving_s + random.standing_s) / len(self.random.poses)
        taken = None if self.same is None else random.pauses_s + each * self.same
        return replace(self, records=drive.own, drive=drive, random_s=taken)

    def to_json(self) -> dict[str, Any]:
        return {
            "kind": "accuracy",
            "n_poses": len(self.records.poses.q),
            "payloads": payload_counts(self.records),
            "noise": self.noise,
            "faults": [fault.to_json() for fault in self.faults],
            "now_mm": self.now_mm,
            "random_mm": self.random_mm,
            "plan_mm": self.plan_mm,
            "random_poses_for_the_same": self.same,
            **self.drive_json(),
        }

    @property
    def headline(self) -> str:
        """In one sentence."""
        error = f"the noise leaves {mm(self.plan_mm)} mm of error in the calibrated model"
        return f"{len(self.records.poses)} poses{self.time}: {error}"

    @property
    def lines(self) -> list[str]:
        """What it brings."""
        now = [] if self.now_mm is None else [f"now {mm(self.now_mm)} mm"]
        n = len(self.records.poses)
        errors = [
            *now,
            f"after {n} random poses {mm(self.random_mm)} mm",
            f"after this plan {mm(self.plan_mm)} mm",
        ]
        lines = [
            f"Expected error of the calibrated model, 3-D, one sigma, from noise alone ({self.noise}): "
            f"{', '.join(errors)}."
        ]
        return lines + self.not_measured + self._gain

    @property
    def text(self) -> str:
        n = len(self.records.poses.q)
        same = f"about {self.same}" if self.same else f"more than {MOST_TRIED * n}"
        lines = [
            "Expected error of the calibrated model, 3-D, one sigma, from noise alone",
            f"({self.noise}):",
            *([] if self.now_mm is None else [f"  {'now':<24} {mm(self.now_mm):>8} mm"]),
            f"  {f'after {n} random poses':<24} {mm(self.random_mm):>8} mm",
            f"  {'after this plan':<24} {mm(self.plan_mm):>8} mm; it takes {same} random poses for the same",
        ]
        if self.drive is not None:
            lines.append(self.drive.text)
        return "\n".join(lines + self.not_measured + self._gain)

    @property
    def _gain(self) -> list[str]:
        if self.gain is None:
            return []
        return [f"Random poses take {self.gain:.1f} times as long for the same accuracy."]
