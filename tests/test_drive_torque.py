"""Drive torques out of Drake: their noise is told from what a wrong load makes of them."""

from dataclasses import replace

import numpy as np
import pytest

from workbench import Truth, load_robot, parse_effect, planned, problem_of, random_poses, simulate
from workbench.campaign import drive_torque
from workbench.diagnosis.prepared import prepare
from workbench.measurement.design.prior_information import from_prepared

SHARE = 0.03
POSES = 24
HIDDEN = {
    "hose": "hose_torque:joint=joint_5,rate=80",
    "gas": "gravity_compensator:variant=charge,relative=-0.2",
    "none": None,
}


def measured(hidden):
    plan = planned(load_robot("kr500"), random_poses(load_robot("kr500"), POSES, np.random.default_rng(3)))
    effects = () if hidden is None else (parse_effect(hidden, problem_of(plan)),)
    truth = Truth(effects=effects, sigma=3e-5)
    exact = simulate(plan, truth, seed=1, torque_sigma=0.0).poses.torque
    return replace(simulate(plan, truth, seed=1, torque_sigma=SHARE), noise_sigma=3e-5), exact


@pytest.mark.parametrize("which", HIDDEN)
def test_a_wrong_load_is_no_noise(which):
    """Joint 1 turns about the vertical: what little it carries is not believed."""
    campaign, exact = measured(HIDDEN[which])
    prepared = prepare(campaign)
    true = SHARE * np.abs(exact).max(axis=0)
    found = prepared.covariance.torque
    assert np.isinf(found[0])
    assert np.isfinite(found[1:4]).all()
    for j in {"hose": (1, 2, 4), "gas": (1, 2), "none": (1, 2)}[which]:
        assert 0.6 * true[j] < found[j] < 2 * true[j]
    if which != "none":
        (j,) = {"hose": (4,), "gas": (1,)}[which]
        assert not drive_torque.noise(prepared.problem)[j] < 1.8 * found[j]


def test_a_load_that_would_have_to_be_too_large_takes_nothing_out():
    campaign, _ = measured(HIDDEN["hose"])
    problem = prepare(campaign).problem
    q = np.zeros((POSES, 6, 1))
    q[:, 4, 0] = -problem.q[:, 4]
    alone = drive_torque.project(problem, q)
    plain, wide, narrow = (drive_torque.scatter(problem, *more) for more in ((), (alone, 1e3), (alone, 50.0)))
    assert wide[4] < 0.5 * plain[4]  # 80 N·m per rad
    assert np.array_equal(narrow, plain)


def brought_by_torques(hose: str) -> float:
    """How much larger the squares of a hose's rows are with torques than without."""
    campaign, _ = measured(HIDDEN["none"])
    effect, _ = parse_effect(hose, problem_of(campaign))
    valued = ((effect, np.zeros(1)),)
    squares = []
    for one in (campaign, campaign.with_poses(torque=None)):
        prior = from_prepared(prepare(one))
        records = prior.records(campaign.poses.q, np.zeros(POSES, dtype=np.int64))
        squares.append((prior.of_records(records, valued).values[..., -1] ** 2).sum())
    return float(squares[0] / squares[1])


def test_records_bring_torques_where_the_campaign_has_them():
    assert brought_by_torques(HIDDEN["hose"]) > 3


def test_no_plan_counts_on_a_column_that_may_stay_quiet():
    """Nothing hangs beside the flange's axis: without a hose its column shows no load, nobody believes it."""
    assert brought_by_torques("hose_torque:joint=joint_6,rate=80") == pytest.approx(1.0)
