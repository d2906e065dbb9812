"""Payloads written at the wrong poses, or in each other's places, are told as that."""

from __future__ import annotations

import numpy as np
import pytest

from workbench import (
    Campaign,
    Truth,
    diagnose,
    load_robot,
    parse_effect,
    planned,
    problem,
    random_poses,
    simulate,
)
from workbench.campaign.payloads import with_payloads
from workbench.files.faults import InputError

WEAK = "joint_compliance:joint=joint_3,relative=0.4"


def measured(robot: str, mass: float, *hidden: str, seed: int = 1, poses: int = 40) -> Campaign:
    """Every other pose carries a payload, the others nothing."""
    arm = load_robot(robot)
    plan = planned(arm, random_poses(arm, poses, np.random.default_rng(seed)))
    plan = with_payloads(plan, {"heavy": (mass, (0.0, 0.0, 0.2))})
    plan = plan.with_poses(payload=np.arange(poses) % 2)
    effects = tuple(parse_effect(text, problem(plan)) for text in hidden)
    return simulate(plan, Truth(effects=effects, sigma=3e-5), seed=seed)


def written_wrongly(campaign: Campaign, poses: list[int]) -> Campaign:
    payload = campaign.poses.payload.copy()
    payload[poses] = 1 - payload[poses]
    return campaign.with_poses(payload=payload)


@pytest.mark.parametrize("poses", [[7], [4, 11, 30], [20, 21, 22, 23, 24, 25]], ids=len)
def test_poses_that_carried_another_payload_are_told_and_taken_under_it(poses: list[int]) -> None:
    campaign = measured("kr500", 250.0, WEAK)
    right, found = (diagnose(c).diagnosis for c in (campaign, written_wrongly(campaign, poses)))
    told = {(fault.kind, fault.pose_id) for fault in found.faults}
    assert told == {("wrong_payload", campaign.poses.ids[n]) for n in poses}
    carries, nothing = "the points fit payload 'heavy', not no payload", "fit no payload, not payload 'heavy'"
    assert (carries if poses[0] % 2 else nothing) in found.faults[0].what
    assert [(c.label, c.status) for c in found.causes] == [(c.label, c.status) for c in right.causes]
    assert found.causes[0].label == "joint_compliance(joint_3)"
    assert found.stages[-1].heldout_rms_mm == pytest.approx(right.stages[-1].heldout_rms_mm, rel=0.05)


@pytest.mark.parametrize(("robot", "mass", "hidden"), [("kr500", 60.0, ()), ("kr500", 250.0, (WEAK,))])
def test_payloads_in_each_others_places_are_refused_with_the_mend(robot, mass, hidden) -> None:
    campaign = measured(robot, mass, *hidden)
    with pytest.raises(InputError) as caught:
        diagnose(written_wrongly(campaign, list(range(campaign.n_poses))))
    (fault,) = caught.value.faults
    assert "payload 'heavy' where no payload is written" in fault.what
    assert "exchange" in fault.mend


def test_a_payload_that_is_misstated_is_a_cause_and_no_mistake_of_rows() -> None:
    found = diagnose(measured("kr500", 250.0, "payload:payload=heavy,mass=60")).diagnosis
    assert not found.faults
    assert [c.label for c in found.causes] == ["payload(heavy)"]


def test_the_test_campaign_is_read_alike() -> None:
    every = measured("kr500", 250.0, poses=60)
    campaign, test = every.some(np.arange(40)), every.some(np.arange(40, 60))
    figures = diagnose(campaign, test=written_wrongly(test, [3, 8])).diagnosis.test
    assert [(f.kind, f.pose_id) for f in figures.faults] == [("wrong_payload", "44"), ("wrong_payload", "49")]
    assert figures.after_rms_mm == pytest.approx(diagnose(campaign, test=test).diagnosis.test.after_rms_mm)
