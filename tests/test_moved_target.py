"""One target of several that is seated anew is named and mended; what creeps or bends is no step."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import SIGMA, measured, with_points

from workbench.campaign.problem import problem_of
from workbench.diagnosis import prepared
from workbench.diagnosis.data_faults.moved_target import explained
from workbench.diagnosis.run import diagnose
from workbench.identification.registration import register


def off_by(campaign, target, shift):
    """The campaign with a target of the flange off by shift (N, 3) [m] on the flange's axes."""
    problem = problem_of(campaign)
    axes = register(problem)[0][campaign.poses.setup] @ problem.rigid.R[-1]
    points = campaign.points.copy()
    points[:, target] += np.einsum("nij,nj->ni", axes, shift)
    return with_points(campaign, points)


def seated_anew(campaign, inside, target=1, size=8 * SIGMA):
    """Off by size [m] in the poses `inside`, a way that neither distances nor the robot show alone."""
    shift = np.zeros((len(campaign.poses), 3))
    shift[inside] = size * np.array([0.6, 0.0, 0.8])
    return off_by(campaign, target, shift)


def said(campaign):
    return [(f.kind, f.pose_id, f.target, f.done) for f in prepared.prepare(campaign).faults]


@pytest.mark.parametrize(
    ("inside", "done"),
    [
        (slice(40, 60), "its 20 points there left out"),
        (slice(25, 60), "its 25 points before left out"),
        (slice(12, 24), "its 12 points there left out"),
        (slice(8, 50), "its 18 points before and after left out"),
    ],
    ids=["late", "early", "for a while", "for most of the time"],
)
@pytest.mark.parametrize("state_sigma", [True, False])
def test_a_target_that_is_seated_anew_is_named_and_its_fewer_points_left_out(inside, done, state_sigma):
    campaign = seated_anew(measured(loads=(), seed=5, state_sigma=state_sigma), inside)
    assert said(campaign) == [("changed_setup", str(inside.start + 1), "T2", done)]


def test_a_seat_far_off_for_a_while_is_one_fault_beside_a_wild_point():
    campaign = seated_anew(measured(loads=(), seed=6), slice(12, 24), size=100 * SIGMA)
    campaign.points[40, 0] += [2e-3, 0.0, 1e-3]
    faults = prepared.prepare(campaign).faults
    assert [(f.kind, f.pose_id, f.target) for f in faults] == [
        ("changed_setup", "13", "T2"),
        ("outlier", "41", "T1"),
    ]
    assert float(faults[0].what.split()[3]) == pytest.approx(3.0, abs=0.03)
    assert faults[0].what.endswith("mm elsewhere from this pose on up to pose 24")


def test_two_targets_that_are_seated_anew_are_two_faults():
    campaign = seated_anew(measured(loads=(), seed=7), slice(35, 60), target=0)
    campaign = seated_anew(campaign, slice(15, 60), target=2)
    assert {(pose, target) for _, pose, target, _ in said(campaign)} == {("36", "T1"), ("16", "T3")}


def test_the_diagnosis_goes_on_as_without_and_says_it():
    gear = "gear_kinematic_error:joint=joint_4,order=200,amplitude=2e-4"
    diagnosis = diagnose(seated_anew(measured(effects=(gear,), seed=8, loads=()), slice(35, 60))).diagnosis
    assert [finding.cause for finding in diagnosis.causes] == ["gear_kinematic_error"]
    assert diagnosis.verdict == "named"
    assert "In these data target T2 sits 0.2" in diagnosis.headline
    assert "mm elsewhere from pose 36 on." in diagnosis.headline


def creeping(campaign, rng):
    share = np.linspace(0.0, 1.0, len(campaign.poses))
    return 10 * SIGMA * (1 - np.exp(-share / rng.uniform(0.05, 1.0)))[:, None] * [0.6, 0.0, 0.8]


def bending(campaign, rng):
    down = problem_of(campaign).rigid.R[-1][:, 2]
    return down @ rng.normal(size=(3, 3)) * 1e-4


def sound(campaign, rng):
    return np.zeros((len(campaign.poses), 3))


@pytest.mark.parametrize("way", [creeping, bending, sound])
@pytest.mark.parametrize("name", ["kr500", "ur10"])
def test_what_creeps_or_bends_or_does_nothing_is_no_step(way, name):
    rng = np.random.default_rng(4)
    for seed in range(5):
        campaign = measured(name, loads=(), seed=seed, targets=2 + seed % 2)
        if way is bending:  # in the order of how the hand is turned
            campaign = campaign.some(np.argsort(problem_of(campaign).rigid.R[-1][:, 2, seed % 3]))
        assert not [f for f in prepared.prepare(off_by(campaign, 1, way(campaign, rng))).faults if f.target]


def test_an_instrument_or_a_tool_that_moved_is_no_single_target():
    campaign = measured(loads=(), seed=9)
    points = campaign.points.copy()
    points[30:] += [4e-4, 0.0, 0.0]
    assert [(f.kind, f.target) for f in prepared.prepare(with_points(campaign, points)).faults] == [
        ("moved_instrument", None)
    ]


def test_repeated_poses_whose_target_moved_between_are_no_noise():
    campaign = seated_anew(measured(poses=25, loads=(), repeats=2, seed=10, state_sigma=False), slice(25, 50))
    ready = prepared.prepare(campaign)
    assert [(f.kind, f.pose_id, f.target) for f in ready.faults] == [("changed_setup", "26", "T2")]
    assert ready.noise.sigma_mm == pytest.approx(1e3 * SIGMA, rel=0.15)


def test_a_step_in_noise_is_as_likely_as_said():
    """The chance of the best of many places is uniform where it is counted for one."""
    rng, start = np.random.default_rng(3), np.array([17])
    chance = [
        explained(rng.normal(size=(40, 3)) * [1, 5, 0.2], rng.normal(size=(40, 4)), start, start + 15)[1][0]
        for _ in range(2000)
    ]
    assert np.mean(np.array(chance) < 0.05) == pytest.approx(0.05, abs=0.015)
    assert np.mean(chance) == pytest.approx(0.5, abs=0.03)


def test_points_that_are_missing_do_no_harm():
    campaign = seated_anew(measured(poses=80, loads=(), seed=11), slice(50, 80))
    lost = np.random.default_rng(0).random(campaign.points.shape[:2]) < 0.15
    points = np.where(lost[..., None], np.nan, campaign.points)
    assert [(kind, target) for kind, _, target, _ in said(replace(campaign, points=points))] == [
        ("changed_setup", "T2")
    ]


def test_a_target_that_only_one_set_up_has_does_no_harm():
    half = ["a"] * 40 + ["b"] * 40
    campaign = seated_anew(measured(poses=80, loads=(), seed=12, setup=half), slice(55, 80))
    campaign.points[:40, 2] = np.nan
    assert said(campaign) == [("changed_setup", "56", "T2", "its 15 points before left out")]
