"""`result.json`: its keys stay the same within a schema number."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ..effects.place import Parameter
    from .result import (
        Decision,
        Diagnosis,
        FaultFound,
        Finding,
        GivenFact,
        Noise,
        OfCampaign,
        Rival,
        Stage,
        TestFigures,
    )


def result_json(result: Diagnosis) -> dict[str, Any]:
    """A diagnosis as JSON has it."""
    return {
        "schema": 1,
        "robot": result.robot,
        "campaign": result.campaign,
        "n_poses": result.n_poses,
        "n_points": result.n_points,
        "noise": _noise(result.noise),
        "stages": [_stage(stage) for stage in result.stages],
        "test": _test(result.test) if result.test else None,
        "verdict": result.verdict,
        "headline": result.headline,
        "causes": [_finding(finding) for finding in result.causes],
        "ceiling": {"heldout_rms_mm": _number(result.ceiling_mm)},
        "remainder": {
            "chi2": _number(result.remainder_chi2),
            "dof": _number(result.remainder_dof),
            "p_value": _number(result.remainder_p),
        },
        "not_testable": [
            {"cause": item.cause, **item.where.keys(), "why": item.why} for item in result.not_testable
        ],
        "detectable": [
            {"cause": item.cause, **item.where.keys(), "size": _number(item.size), "unit": item.unit}
            for item in result.detectable
        ],
        "faults": [fault_json(fault) for fault in result.faults],
        "bounds_mm": _bounds(result.bounds_mm),
        "notes": list(result.notes),
        "given": [_given(fact) for fact in result.given],
        **({"campaigns": [_of_campaign(one) for one in result.campaigns]} if result.campaigns else {}),
        "inputs": dict(result.inputs),
        "version": result.version,
    }


def _noise(noise: Noise) -> dict[str, Any]:
    left = {} if noise.left_mm is None else {"left_mm": _number(noise.left_mm)}
    return {"sigma_mm": _number(noise.sigma_mm), "source": noise.source, **left}


def _bounds(bounds: tuple[float, float] | None) -> dict[str, float | None] | None:
    """What correction leaves, 95 %."""
    return None if bounds is None else dict(zip(("measured", "all_over"), map(_number, bounds), strict=True))


def _number(value: float) -> float | None:
    """A JSON number; not a number and infinite become null."""
    return float(value) if np.isfinite(value) else None


def _stage(stage: Stage) -> dict[str, Any]:
    return {
        "name": stage.name,
        "parameters": stage.parameters,
        "heldout_rms_mm": _number(stage.heldout_rms_mm),
        "heldout_mean_mm": _number(stage.heldout_mean_mm),
        "heldout_max_mm": _number(stage.heldout_max_mm),
        "fit_rms_mm": _number(stage.fit_rms_mm),
        **({"note": stage.note} if stage.note else {}),
    }


def _of_campaign(one: OfCampaign) -> dict[str, Any]:
    return {
        "campaign": one.label,
        "n_poses": one.n_poses,
        "n_points": one.n_points,
        "noise": {"sigma_mm": _number(one.noise_mm), "source": one.noise_source},
        "nominal_rms_mm": _number(one.nominal_mm),
        "geometry_rms_mm": _number(one.geometry_mm),
        "after_rms_mm": _number(one.after_mm),
        "of_model": one.of_model,
    }


def _test(test: TestFigures) -> dict[str, Any]:
    return {
        "campaign": test.campaign,
        "before_mean_mm": _number(test.before_mean_mm),
        "after_mean_mm": _number(test.after_mean_mm),
        "after_rms_mm": _number(test.after_rms_mm),
        "after_max_mm": _number(test.after_max_mm),
        "before_max_mm": _number(test.before_max_mm),
        "n_points": test.n_points,
        "all_mean_mm": _number(test.all_mean_mm),
        "all_rms_mm": _number(test.all_rms_mm),
        "faults": [fault_json(fault) for fault in test.faults],
        "notes": list(test.notes),
        "moved": [
            {"setup": setup, "moved_mm": _number(moved), "anew_mean_mm": _number(left)}
            for setup, moved, left in test.moved
        ],
    }


def _finding(finding: Finding) -> dict[str, Any]:
    return {
        "cause": finding.cause,
        **finding.where.keys(),
        **({"variant": finding.variant} if finding.variant else {}),
        "status": finding.status,
        "gain_mm": _number(finding.gain_mm),
        "probability": _number(finding.probability),
        "parameters": [_parameter(p) for p in finding.parameters],
        "rivals": [_rival(rival) for rival in finding.rivals],
        **({"faint": [_rival(rival) for rival in finding.faint]} if finding.faint else {}),
        "separate_by": _separate_by(finding),
        **({"decide": [_decision(one) for one in finding.decide]} if finding.decide else {}),
        **({"structure": finding.structure} if finding.structure else {}),
    }


def _rival(rival: Rival) -> dict[str, Any]:
    return {"cause": rival.cause, **rival.where.keys(), "probability": _number(rival.probability)}


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
    after = None if one.lambda_after is None else _number(one.lambda_after)
    return {
        "kind": one.kind,
        "words": one.words,
        "command": one.command,
        "poses": one.poses,
        "lambda_before": _number(one.lambda_before),
        "lambda_after": after,
    }


def _parameter(p: Parameter) -> dict[str, Any]:
    return {"name": p.name, "value": _number(p.value), "std": _number(p.std), "unit": p.unit}


def _given(fact: GivenFact) -> dict[str, Any]:
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


def fault_json(fault: FaultFound) -> dict[str, Any]:
    optional = {"target": fault.target, "what": fault.what, "done": fault.done}
    return {
        "kind": fault.kind,
        "pose_id": fault.pose_id,
        **{key: value for key, value in optional.items() if value},
    }
