"""A comparison as JSON."""

from __future__ import annotations

from typing import Any

from ...effects.place import Parameter, Where
from .result import Apart, Change, Comparison


def as_json(comparison: Comparison) -> dict[str, Any]:
    """For programs; lengths and angles of numbers in SI units, what has `_mm` in mm."""
    return {
        "schema": 1,
        "robot": comparison.robot,
        "campaigns": [
            {"label": label, "n_poses": n}
            for label, n in zip(comparison.campaigns, comparison.n_poses, strict=True)
        ],
        "verdict": "changed" if comparison.changed else "unchanged",
        "headline": comparison.headline,
        "changes": [_change(change) for change in comparison.changes],
        "unchanged_within_mm": comparison.within_mm,
        "nominal_mm": comparison.nominal_mm,
        "unchanged": [
            {
                **_placed(item.label, item.cause, item.where, item.side),
                "difference": _number(item.number),
                "detectable": item.detectable,
                "detectable_mm": item.detectable_mm,
            }
            for item in comparison.unchanged
        ],
        "not_testable": [{"what": item.label, "same_as": item.same_as} for item in comparison.unseen],
        "repeats": [
            {"what": item.label, "status": item.status, "within_share": item.share}
            for item in comparison.repeats
        ],
        "apart": [_apart(item) for item in comparison.apart],
        "chart": [
            {
                "what": track.label,
                "unit": track.unit,
                "values": list(track.values),
                "std": list(track.stds),
                "limit": track.limit,
            }
            for track in comparison.chart
        ],
        "notes": list(comparison.notes),
        "inputs": dict(comparison.inputs),
    }


def _placed(label: str, cause: str, where: Where, side: str) -> dict[str, Any]:
    return {"what": label, "cause": cause, **where.keys(), "side": side}


def _number(p: Parameter) -> dict[str, Any]:
    return {"name": p.name, "value": p.value, "std": p.std, "unit": p.unit, "interval": list(p.interval)}


def _change(item: Change) -> dict[str, Any]:
    return {
        **_placed(item.label, item.cause, item.where, item.side),
        "status": item.status,
        "placed": item.placed,
        "since": item.since,
        "alone": item.alone,
        "course": item.course,
        "probability": item.probability,
        "parameters": [_number(p) for p in item.parameters],
        "levels": [
            {"campaign": label, "parameters": [_number(p) for p in numbers]} for label, numbers in item.levels
        ],
        "before": [_number(p) for p in item.before],
        "after": [_number(p) for p in item.after],
        "moves_mm": item.moves_mm,
        "rivals": [
            {**_placed(r.label, r.cause, r.where, r.side), "change": r.change, "probability": r.probability}
            for r in item.rivals
        ],
        "recheck": {"poses": item.recheck_poses, "pose_ids": list(item.recheck_ids)},
    }


def _apart(item: Apart) -> dict[str, Any]:
    return {
        "label": item.label,
        "frame": {
            "shift_mm": item.frame_mm,
            "shift_std_mm": item.frame_std_mm,
            "turn_mrad": item.frame_mrad,
            "turn_std_mrad": item.frame_std_mrad,
        },
        "targets_moved": item.targets_moved,
        "targets": [
            {
                "target": t.target,
                "on": t.on,
                "by_mm": list(t.by_mm),
                "std_mm": list(t.std_mm),
                "moved": t.moved,
                "stated_mm": None if t.stated_mm is None else list(t.stated_mm),
                "as_stated": t.as_stated,
                "off_stated_mm": None if t.stated_mm is None else t.off_stated_mm,
            }
            for t in item.targets
        ],
        "moved_together": [
            {
                "on": one.link,
                "targets": list(one.targets),
                "as_zero_of": one.joint,
                "turn_mrad": one.turn_mrad,
                "turn_std_mrad": one.turn_std_mrad,
            }
            for one in item.moves.together
        ],
        "noise": {"sigma_mm": item.sigma_mm, "source": item.source},
        "scatter": {
            "sigma_mm": item.scatter.sigma_mm,
            "std_mm": item.scatter.std_mm,
            "times_first": item.scatter.times,
            "p_value": item.scatter.p_value,
        },
        "rms_mm": item.scatter.rms_mm,
        "temperature_degC": item.temperature,
    }
