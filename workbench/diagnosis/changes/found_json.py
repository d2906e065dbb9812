"""The parts of a comparison as JSON: lengths and angles of numbers in SI units, what has `_mm` in mm."""

from __future__ import annotations

from typing import Any

from ...effects.place import Parameter, Where
from .found import Apart, Change


def placed_json(label: str, cause: str, where: Where, side: str) -> dict[str, Any]:
    return {"what": label, "cause": cause, **where.keys(), "side": side}


def number_json(p: Parameter) -> dict[str, Any]:
    return {"name": p.name, "value": p.value, "std": p.std, "unit": p.unit, "interval": list(p.interval)}


def change_json(item: Change) -> dict[str, Any]:
    return {
        **placed_json(item.label, item.cause, item.where, item.side),
        "status": item.status,
        "placed": item.placed,
        "since": item.since,
        "alone": item.alone,
        "course": item.course,
        "probability": item.probability,
        "parameters": [number_json(p) for p in item.parameters],
        "levels": [
            {"campaign": label, "parameters": [number_json(p) for p in numbers]}
            for label, numbers in item.levels
        ],
        "before": [number_json(p) for p in item.before],
        "after": [number_json(p) for p in item.after],
        "moves_mm": item.moves_mm,
        "rivals": [
            {
                **placed_json(r.label, r.cause, r.where, r.side),
                "change": r.change,
                "probability": r.probability,
            }
            for r in item.rivals
        ],
        "recheck": {"poses": item.recheck_poses, "pose_ids": list(item.recheck_ids)},
    }


def apart_json(item: Apart) -> dict[str, Any]:
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
