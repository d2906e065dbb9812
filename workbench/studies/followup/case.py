"""One case: a fault of the blind study's, diagnosed from a first campaign, the unloaded poses that a morning
gives; where it stays open, the follow-up that is offered, measured in Drake, and both diagnosed together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from zlib import crc32

import numpy as np

from ...campaign import Campaign
from ...campaign.drives import ACCURACY
from ...diagnosis.found import Decision, Finding
from ...diagnosis.run import Outcome, diagnose
from ...effects.base import UNKNOWN
from ...measurement.design import follow_up, what_decides
from ...measurement.design.decide import SETTLE
from ...measurement.design.ties import Tie, settled_at, tie_of, told_apart
from ...simulation.virtual_campaign import simulate
from ..blind.cases import Case, draw_case, true_robot
from ..blind.score import facts, key_of, label_of
from ..blind.sight import Key, planned_for
from ..case_study import Record

FIRST = 24  # poses of a first campaign
MOST = 30  # poses of a follow-up


@dataclass(frozen=True)
class Offer:
    """A finding that stays open, and the poses that are offered to settle it."""

    finding: Finding
    tie: Tie
    decision: Decision


def run_case(key: str, seed: int) -> Record:
    """What the first campaign of a key left open, what was offered for it, and what came of that."""
    with TemporaryDirectory() as folder:
        case = draw_case(key, seed, Path(folder))
        first = first_campaign(case.campaign)
        before = what_decides(diagnose(first))
        record = {**facts(case), "before": _said(before), "open": bool(_open(before)), "offered": None}
        offer = offered(before)
        if offer is None:
            decisions = [d.kind for f in _open(before) for d in f.decide]
            return {**record, "other_ways": list(dict.fromkeys(decisions))}
        return {**record, **_followed(case, first, before, offer, crc32(key.encode()))}


def first_campaign(campaign: Campaign) -> Campaign:
    """The first `FIRST` of its poses without a payload."""
    return campaign.some(np.flatnonzero(campaign.poses.payload == 0)[:FIRST])


def _open(outcome: Outcome) -> list[Finding]:
    return [f for f in outcome.diagnosis.causes if f.status == "ambiguous"]


def offered(outcome: Outcome) -> Offer | None:
    """The strongest open finding that at most `MOST` poses settle; poses alone before poses with torques."""
    for finding in _open(outcome):
        tie = tie_of(outcome, finding)
        ways = [d for d in finding.decide if d.kind in SETTLE and (d.poses or 0) <= MOST]
        if tie is not None and ways:
            return Offer(finding, tie, min(ways, key=lambda way: way.kind != "poses"))
    return None


def _followed(case: Case, first: Campaign, before: Outcome, offer: Offer, seed: int) -> Record:
    """What came of an offer."""
    decision = offer.decision
    made = follow_up(first, decision, seed=seed, quick=True)
    record: Record = {
        "offered": {
            "kind": decision.kind,
            "poses": decision.poses,
            "finding": offer.finding.label,
            "rivals": [label_of((r.cause, r.where)) for r in offer.finding.rivals],
            "lambda_before": decision.lambda_before,
            "lambda_needed": settled_at(decision.lambda_before),
            "lambda_promised": decision.lambda_after,
        }
    }
    if made.drive is None:
        return {**record, "came_of_it": "open", "after": [made.text.split("\n")[0]], "lambda_reached": None}
    measured = _measured(case, made.drive.records, seed, decision.kind == "drive_torque")
    after = diagnose([first, measured])
    keys = {offer.tie.effect.key, *(rival.key for rival in offer.tie.rivals)}
    return {
        **record,
        "standstills": len(measured.poses),
        "minutes": made.drive.total_s / 60,
        "after": _said(after),
        "lambda_reached": told_apart(after, offer.tie, before),
        "came_of_it": judged(after, case.truths, keys),
    }


def _measured(case: Case, records: Campaign, seed: int, torque: bool) -> Campaign:
    """The records of a plan, measured on the case's true robot, the instrument set up anew; where there was a
    thermometer, in an arm that stays as warm as it was at some time of the first campaign."""
    truth = true_robot(case.design, case.hidden, case.sizes)
    names = [target.name for target in case.campaign.targets]
    assert truth.targets is not None
    truth = replace(truth, targets=truth.targets[[names.index(t.name) for t in records.targets]])
    before = case.campaign.poses.temperature
    if before is not None and records.poses.temperature is None:
        warm = np.random.default_rng([seed, 29]).choice(before)
        records = records.with_poses(temperature=np.full(len(records.poses), warm))
    return simulate(
        replace(planned_for(records, case.hidden, case.sizes), path=Path("follow-up/campaign.toml")),
        truth,
        seed=seed,
        state_sigma=case.design.stated,
        torque_sigma=ACCURACY if torque else None,
    )


def judged(after: Outcome, truths: list[Key], tie: set[Key]) -> str:
    """right: all that is true of the tie is named, and nothing that is not there; wrong: something that is
    not there is named; open: neither. Causes that look exactly alike count as what they are called."""
    named = {key_of(f) for f in after.diagnosis.causes if f.status == "named" and f.cause != UNKNOWN}
    if named - set(truths):
        return "wrong"
    asked = [truth for truth in truths if truth in tie] or truths
    return "right" if named.issuperset(asked) else "open"


def _said(outcome: Outcome) -> list[str]:
    out = []
    for f in outcome.diagnosis.causes:
        rivals = ", ".join(label_of((r.cause, r.where)) for r in f.rivals)
        out.append(f"{f.label} {f.status} {f.probability:.3f}" + (f" or {rivals}" if rivals else ""))
    return out
