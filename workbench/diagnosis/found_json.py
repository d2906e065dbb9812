"""The parts of a diagnosis as `result.json` has them: its keys stay the same within a schema number."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..effects.place import Parameter
from .found import Decision, Finding, GivenFact, Noise, OfCampaign, Rival, Stage, TestFigures


def noise_json(noise: Noise) -> dict[str, Any]:
    left = {} if noise.left_mm is None else {"left_mm": number_json(noise.left_mm)}
    return {"sigma_mm": number_json(noise.sigma_mm), "source": noise.source, **left}


def bounds_json(bounds: tuple[float, float] | None) -> dict[str, float | None] | None:
    """What correction leaves, 95 %."""
    return (
        None if bounds is None else dict(zip(("measured", "all_over"), map(number_json, bounds), strict=True))
    )


def number_json(value: float) -> float | None:
    """A JSON number; not a number and infinite become null."""
    return float(value) if np.isfinite(value) else None


def stage_json(stage: Stage) -> dict[str, Any]:
    return {
        "name": stage.name,
        "parameters": stage.parameters,
        "heldout_rms_mm": number_json(stage.heldout_rms_mm),
        "heldout_mean_mm": number_json(stage.heldout_mean_mm),
        "heldout_max_mm": number_json(stage.heldout_max_mm),
        "fit_rms_mm": number_json(stage.fit_rms_mm),
        **({"note": stage.note} if stage.note else {}),
    }


def of_campaign_json(one: OfCampaign) -> dict[str, Any]:
    return {
        "campaign": one.label,
        "n_poses": one.n_poses,
        "n_points": one.n_points,
        "noise": {"sigma_mm": number_json(one.noise_mm), "source": one.noise_source},
        "nominal_rms_mm": number_json(one.nominal_mm),
        "geometry_rms_mm": number_json(one.geometry_mm),
        "after_rms_mm": number_json(one.after_mm),
        "of_model": one.of_model,
    }


def figures_json(test: TestFigures) -> dict[str, Any]:
    return {
        "campaign": test.campaign,
        "before_mean_mm": number_json(test.before_mean_mm),
        "after_mean_mm": number_json(test.after_mean_mm),
        "after_rms_mm": number_json(test.after_rms_mm),
        "after_max_mm": number_json(test.after_max_mm),
        "before_max_mm": number_json(test.before_max_mm),
        "n_points": test.n_points,
        "all_mean_mm": number_json(test.all_mean_mm),
        "all_rms_mm": number_json(test.all_rms_mm),
        "faults": [fault.to_json() for fault in test.faults],
        "notes": list(test.notes),
        "moved": [
            {"setup": setup, "moved_mm": number_json(moved), "anew_mean_mm": number_json(left)}
            for setup, moved, left in test.moved
        ],
    }


def finding_json(finding: Finding) -> dict[str, Any]:
    return {
        "cause": finding.cause,
        **finding.where.keys(),
        **({"variant": finding.variant} if finding.variant else {}),
        "status": finding.status,
        "gain_mm": number_json(finding.gain_mm),
        "probability": number_json(finding.probability),
        "parameters": [_parameter(p) for p in finding.parameters],
        "rivals": [_rival(rival) for rival in finding.rivals],
        **({"faint": [_rival(rival) for rival in finding.faint]} if finding.faint else {}),
        "separate_by": _separate_by(finding),
        **({"decide": [_decision(one) for one in finding.decide]} if finding.decide else {}),
        **({"structure": finding.structure} if finding.structure else {}),
    }


def _rival(rival: Rival) -> dict[str, Any]:
    return {"cause": rival.cause, **rival.where.keys(), "probability": number_json(rival.probability)}


def _separate_by(finding: Finding) -> dict[str, Any] | None:
    """What would decide: of what can be run the first, its words beside its command (the others: `decide`);
    in words alone where nothing can be run. `advice`: what such causes are told apart by in general, or the
    first of what would decide where that is all."""
    words = finding.separate_by or next((one.words for one in finding.decide), None)
    if words is None:
        return None
    said = {"kind": None, "words": words, "command": None, "poses": None}
    said |= {"lambda_before": None, "lambda_after": None}
    ready = said if finding.ready is None else _decision(finding.ready)
    return {**ready, "advice": words}


def _decision(one: Decision) -> dict[str, Any]:
    after = None if one.lambda_after is None else number_json(one.lambda_after)
    return {
        "kind": one.kind,
        "words": one.words,
        "command": one.command,
        "poses": one.poses,
        "lambda_before": number_json(one.lambda_before),
        "lambda_after": after,
    }


def _parameter(p: Parameter) -> dict[str, Any]:
    return {"name": p.name, "value": number_json(p.value), "std": number_json(p.std), "unit": p.unit}


def given_json(fact: GivenFact) -> dict[str, Any]:
    numbers = {"given": fact.given, "seen": fact.seen, "fitted": fact.fitted}
    return {
        "cause": fact.cause,
        **fact.where.keys(),
        "said": fact.said,
        **({"note": fact.note} if fact.note else {}),
        **{name: _parameter(p) for name, p in numbers.items() if p is not None},
        "obeyed": fact.obeyed,
        "confirmed": bool(fact.differs),
        "sentence": fact.sentence,
    }
