"""What every plan says of how it is driven."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

from ...diagnosis.found import FaultFound
from ..driving.block import Drive
from ..driving.reach import Reach


@dataclass(frozen=True, kw_only=True)
class DrivenPlan(ABC):
    """faults: of the campaign's data; reach: the robot in its cell; drive: how the records are driven,
    random_s: [s] that driving random ones takes. Of a plan in a time, over_poses: information per hour over
    that of poses alone (None: these tell nothing); stops: between two poses; skipped: targets that are not
    worth their time."""

    faults: tuple[FaultFound, ...] = ()
    reach: Reach | None = None
    drive: Drive | None = None
    random_s: float | None = None
    over_poses: float | None = None
    stops: int = 0
    skipped: tuple[str, ...] = ()

    @property
    @abstractmethod
    def gain(self) -> float | None:
        """Information per hour over that of random records; None where it is not driven."""

    @property
    def time(self) -> str:
        """About how long it takes, as the end of a phrase."""
        return "" if self.drive is None else f" in about {self.drive.total_s / 60:.0f} min"

    @property
    def not_measured(self) -> list[str]:
        """Which targets are left out, in words."""
        if not self.skipped:
            return []
        return [f"Leave out {', '.join(self.skipped)}: more poses are worth more. Random poses are with all."]

    def drive_json(self) -> dict[str, Any]:
        """How it is driven, as `plan.json` has it."""
        return {
            "drive": None if self.drive is None else self.drive.to_json(),
            "information_per_hour_over_random": self.gain,
            "information_per_hour_over_poses_alone": self.over_poses,
            "stops_on_the_way": self.stops,
            "targets_left_out": list(self.skipped),
        }
