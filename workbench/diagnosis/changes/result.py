"""The one result of a comparison: pages and `comparison.json` read it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .found import Apart, Change, Repeats, Track, Unchanged, Unseen, bounds
from .found_json import apart_json, change_json, number_json, placed_json

UNCHANGED, CHANGED = 0, 3  # exit status of `compare --exit-code`


@dataclass(frozen=True)
class Comparison:
    """What changed between campaigns of one robot.

    said: what changed and what did not, in a sentence; elsewhere: of which campaigns hardly a pose was
    compared, if any. changed: whether the robot did, with a probability of 0.95 or more. within_mm: 95 %
    bound of what all other changes of geometry together make of the points in the poses of all campaigns
    (RMS, frame and targets fitted anew). nominal_mm: RMS that the nominal robot is off. inputs:
    "<folder>/<file>" → SHA-256."""

    robot: str
    title: str
    campaigns: tuple[str, ...]
    n_poses: tuple[int, ...]
    changed: bool
    said: str
    elsewhere: str
    changes: tuple[Change, ...]
    within_mm: float
    nominal_mm: float
    unchanged: tuple[Unchanged, ...]
    unseen: tuple[Unseen, ...]
    repeats: tuple[Repeats, ...]
    apart: tuple[Apart, ...]
    chart: tuple[Track, ...]
    notes: tuple[str, ...]
    inputs: Mapping[str, str] = field(default_factory=dict)

    @property
    def headline(self) -> str:
        """All of it in one line."""
        return f"{self.said} {self.elsewhere}".strip()

    @property
    def bounded(self) -> bool:
        """Whether `within_mm` says something, as `bounds`."""
        return bounds(self.within_mm, self.nominal_mm, self.changes)

    @property
    def exit_status(self) -> int:
        """3 where the robot changed, else 0."""
        return CHANGED if self.changed else UNCHANGED

    def __repr__(self) -> str:
        return f"Comparison of {', '.join(self.campaigns)}: {self.headline}"

    def to_json(self) -> dict[str, Any]:
        """For programs; lengths and angles of numbers in SI units, what has `_mm` in mm."""
        return {
            "schema": 1,
            "robot": self.robot,
            "campaigns": [
                {"label": label, "n_poses": n} for label, n in zip(self.campaigns, self.n_poses, strict=True)
            ],
            "verdict": "changed" if self.changed else "unchanged",
            "headline": self.headline,
            "changes": [change_json(change) for change in self.changes],
            "unchanged_within_mm": self.within_mm,
            "nominal_mm": self.nominal_mm,
            "unchanged": [
                {
                    **placed_json(item.label, item.cause, item.where, item.side),
                    "difference": number_json(item.number),
                    "detectable": item.detectable,
                    "detectable_mm": item.detectable_mm,
                }
                for item in self.unchanged
            ],
            "not_testable": [{"what": item.label, "same_as": item.same_as} for item in self.unseen],
            "repeats": [
                {"what": item.label, "status": item.status, "within_share": item.share}
                for item in self.repeats
            ],
            "apart": [apart_json(item) for item in self.apart],
            "chart": [
                {
                    "what": track.label,
                    "unit": track.unit,
                    "values": list(track.values),
                    "std": list(track.stds),
                    "limit": track.limit,
                }
                for track in self.chart
            ],
            "notes": list(self.notes),
            "inputs": dict(self.inputs),
        }
