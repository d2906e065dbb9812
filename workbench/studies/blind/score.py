"""One case, diagnosed and judged: what was said, what was true, and how the numbers compare."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ...campaign import Campaign
from ...diagnosis.found import Finding, Rival
from ...diagnosis.run import Outcome, diagnose
from ...diagnosis.telling.on_test_campaign import test_figures
from ...effects.base import UNKNOWN, Effect
from ...identification.fit import Fit, refit
from ...robot.kinematics import Array
from ...robot.rotations import body_jacobian
from ..case_study import Record
from .cases import Case, draw_case
from .observer import reported_at_best
from .sight import Key, Products

NEAREST = 4  # rivals that are noted
WORTH = 8.0  # λ by which a further part of the true cause must help to be in the right model


def run_case(key: str, seed: int, report: Path | None = None) -> Record:
    """Draws, diagnoses and judges the case of a key; writes its page and report under `report`."""
    with TemporaryDirectory() as folder:
        start = time.perf_counter()
        case = draw_case(key, seed, Path(folder))
        drawn = time.perf_counter() - start
        start = time.perf_counter()
        outcome = diagnose(case.campaign, case.judge)
        seconds = time.perf_counter() - start
        if report is not None:
            from ...report.outcome import write_outcome

            write_outcome(outcome, report / key.replace("/", "-"))
        return {**facts(case), **judged(case, outcome), "seconds": seconds, "seconds_drawn": drawn}


def facts(case: Case) -> Record:
    """What was hidden, and in what."""
    design, products = case.design, case.products
    truths = [
        {
            "label": item.label,
            "cause": item.name,
            **(item.effect.where.keys() if item.effect is not None else {}),
            "variant": item.effect.variant if item.effect is not None else "",
            "strength": strength,
            "values": [float(v) for v in item.values(size)],
            "size": size,
        }
        for item, size, strength in zip(case.hidden, case.sizes, case.strength, strict=True)
    ]
    return {
        "key": case.key,
        "robot": case.robot,
        "records": len(case.campaign.poses.q),
        "targets": len(case.campaign.targets),
        "loads": len(case.campaign.payload_names),
        "noise": "stated" if design.stated else "repeats",
        "sigma_mm": 1e3 * design.sigma,
        "repeatability_urad": 1e6 * float(design.repeatability.mean()),
        "columns": [n for n in ("side", "time", "temperature", "readback") if _has(case.campaign, n)],
        "truths": truths,
        "unknown_mm": case.unknown_mm,
        "nearest": _nearest(products, case.truths) if products is not None else [],
        "form_left": case.form_left if products is not None else None,
        "at_best": _at_best(case, products) if products is not None else None,
    }


def _has(campaign: Campaign, name: str) -> bool:
    return getattr(campaign.poses, name) is not None


def _nearest(products: Products, truths: Sequence[Key]) -> list[Record]:
    """Causes that could take over most, alone or (of two) beside nothing else, and the λ they leave."""
    alone = [(products.left(members), key) for key, members in products.keys().items() if key not in truths]
    alone.sort(key=lambda pair: pair[0])
    return [{"label": label_of(key), "left": left} for left, key in alone[:NEAREST]]


def _at_best(case: Case, products: Products) -> float:
    """Chance that the weakest thing hidden is reported by one who knows its shape."""
    every = products.keys()
    places = Counter(cause for cause, _ in every)
    pairs = zip(case.hidden, case.strength, strict=True)
    return min(reported_at_best(strength, max(places[item.name], 1)) for item, strength in pairs)


def label_of(key: Key) -> str:
    return f"{key[0]}({key[1]})" if str(key[1]) else key[0]


def judged(case: Case, outcome: Outcome) -> Record:
    """What the diagnosis said, against the truth."""
    found = outcome.diagnosis
    truths = case.truths
    real = [f for f in found.causes if f.cause != "unknown"]
    reported = {key for f in real for key in _offered(f)}
    twins = _twins(case, [key_of(f) for f in real])
    first = key_of(real[0]) if real else None
    right = set(truths) | twins
    named = [f for f in real if f.status == "named"]
    return {
        "verdict": found.verdict,
        "found": [_said(case, f) for f in found.causes],
        "stated": [[p, key in right] for f in real for key, p in _stated(f)]
        if case.unknown_mm is None
        else [],
        "first": real[0].cause if real else ("unknown" if found.causes else "nothing"),
        "first_right": first in right if truths else None,
        "reported": all(truth in reported for truth in truths) if truths else None,
        "order_right": _order_right(case, real),
        "wrong_name": any(key_of(f) not in right for f in named),
        "first_wrong_name": bool(named) and named[0] is real[0] and first not in right,
        "nothing_else": all(right & _offered(f) for f in found.causes),
        "only_right": all(key_of(f) in right for f in found.causes),
        "unknown": found.verdict == "unknown",
        "false_alarm": found.verdict != "nothing_missing" if not case.hidden else None,
        "faults": [f.kind for f in found.faults],
        **_intervals(case, outcome),
        **_heldout(case, outcome),
    }


def key_of(said: Finding | Rival) -> Key:
    """Cause and place of a finding or a rival, a gear line at any order."""
    return said.cause, said.where.any_order


def _offered(finding: Finding) -> set[Key]:
    """The cause that is reported and those that may stand in its place."""
    return {key_of(finding), *map(key_of, finding.rivals)}


def _stated(finding: Finding) -> list[tuple[Key, float]]:
    """What is reported and each rival of a cause, with the probability that is stated of it."""
    rivals = [rival for rival in finding.rivals if rival.cause != UNKNOWN]
    said: list[Finding | Rival] = [finding, *rivals]
    return [(key_of(one), one.probability) for one in said]


def _twins(case: Case, found: Sequence[Key]) -> set[Key]:
    """Those found that are exact twins of a true cause in these poses."""
    if case.products is None:
        return set()
    keys = case.products.keys()
    true = [item.effect for item in case.hidden if item.effect is not None]
    return {key for key in found if key in keys and any(case.products.twins(keys[key], e) for e in true)}


def _said(case: Case, finding: Finding) -> Record:
    """A finding; left: λ of the truth that this cause, alone, would leave."""
    members = case.products.keys().get(key_of(finding)) if case.products is not None else None
    return {
        "label": finding.label,
        **({"order": finding.where.order} if finding.where.order is not None else {}),
        "status": finding.status,
        "probability": finding.probability,
        "rivals": [label_of((r.cause, r.where)) for r in finding.rivals],
        **({"left": case.products.left(members)} if members and case.products is not None else {}),
        **({"structure": finding.structure} if finding.structure else {}),
    }


def _order_right(case: Case, found: Sequence[Finding]) -> bool | None:
    """Whether a gear line was found at its order, as well as the joint's range can tell."""
    item = next((h for h in case.hidden if h.effect is not None and h.effect.where.order is not None), None)
    if item is None or item.effect is None or item.effect.where.order is None:
        return None
    effect, order = item.effect, item.effect.where.order
    j = case.campaign.robot.joint_names.index(str(effect.where.joint))
    width = max(np.pi / float(np.ptp(case.campaign.poses.q[:, j])), 0.3)
    return any(key_of(f) == effect.key and abs((f.where.order or 0.0) - order) < width for f in found)


def _intervals(case: Case, outcome: Outcome) -> Record:
    """How many standard deviations the main parameters of true causes that are reported are off: z from what
    data without noise would give in the catalogue's form, z_form from what was hidden."""
    accepted = outcome.fit.model.effects
    out: Record = {"z": {}, "z_form": {}}
    if not accepted or not case.hidden or outcome.problem.campaign.setup_names != ("",):
        return out
    reported = {key_of(finding) for finding in outcome.diagnosis.causes}
    ideal = case.sight.values(case.sight.shift(case.hidden, case.sizes), accepted)
    for item, size in zip(case.hidden, case.sizes, strict=True):
        for i, effect in enumerate(accepted):
            if effect != item.effect or effect.key not in reported or effect.cause == "lost_motion":
                continue
            values, covariance = outcome.fit.effect_values(i)
            said = effect.report(values, covariance)
            true = effect.report(ideal[i], covariance)
            hidden = effect.report(item.values(size), covariance)
            main = next((n for n, p in enumerate(said) if p.name != "phase"), 0)
            out["z"][item.label] = (said[main].value - true[main].value) / said[main].std
            out["z_form"][item.label] = (said[main].value - hidden[main].value) / said[main].std
    return out


def _heldout(case: Case, outcome: Outcome) -> Record:
    """Error [mm, rms of 3-D norms] at other poses against the truth without noise, of the final model and
    of one with the right causes; and what the right one must have at least (Cramér–Rao)."""
    test = outcome.diagnosis.test
    assert test is not None
    out: Record = {"error_mm": test.after_rms_mm, "right_error_mm": None, "bound_mm": None}
    if outcome.problem.campaign.setup_names != ("",) or case.unknown_mm is not None:
        return out
    right = refit(outcome.fit, right_model(case))
    J = sensitivity(right, case.judge)
    bound = np.einsum("nij,jk,nik->ni", J, right.covariance, J)
    out["right_error_mm"] = test_figures(right, right, case.judge).after_rms_mm
    out["bound_mm"] = 1e3 * float(np.sqrt(3 * bound.mean()))
    return out


def right_model(case: Case) -> list[Effect]:
    """The effects of the catalogue that describe best what is hidden, part after part while it helps."""
    products = case.products
    if products is None:
        return []
    chosen: list[int] = []
    for item in case.hidden:
        assert item.effect is not None
        rest = list(products.keys()[item.effect.key])
        first = True
        while rest:
            best = min(rest, key=lambda k: products.left([*chosen, k]))
            if not first and products.left(chosen) - products.left([*chosen, best]) < WORTH:
                break
            chosen.append(best)
            rest.remove(best)
            first = False
    return [products.effects[k] for k in chosen]


def sensitivity(result: Fit, campaign: Campaign) -> Array:
    """(N, 3T, P) motion of a campaign's points per unit of a fit's numbers; one set-up."""
    model = replace(result.model, problem=replace(result.model.problem, campaign=campaign))
    line, cols = model.linearise(result.state), result.columns
    J = np.zeros((*line.direct.shape[:2], len(cols.names)))
    arms = line.prediction.points - result.line.centre[0]  # the fit's frame turned about its own centre
    J[:, :, :6] = body_jacobian(arms).reshape(*J.shape[:2], 6)
    for _, i, part in cols.targets:
        assert i is not None
        J[:, 3 * i : 3 * i + 3, part] = line.target[:, i]
    J[:, :, cols.geometry_slice] = line.geometry[:, :, cols.geometry]
    for part, effect, values in zip(cols.effect, model.effects, result.state.values, strict=True):
        J[:, :, part] = model.effect_jacobian(line, effect, values)
    return J
