"""Noise that is stated too small or too large: what proves it, and what a diagnosis then says."""

from dataclasses import replace

import numpy as np
import pytest

from workbench import Truth, diagnose, load_robot, parse_effect, planned, random_poses, simulate
from workbench.campaign import load_campaign, write_campaign
from workbench.campaign.planned import TARGETS
from workbench.campaign.problem import problem_of
from workbench.diagnosis.noise.distances import shown_by_distances
from workbench.diagnosis.prepared import prepare
from workbench.identification.noise import stated_noise

SIGMA = 5e-5
PROOF = "Distances between targets, which no robot changes, scatter as by"


def measured(said, *, targets=3, poses=40, seed=1, name="ur10", sigma=SIGMA, shake=0.0):
    """Random poses of a robot that repeats exactly, but for all its targets of a pose together (`shake` [m]);
    `said` [m] is stated as noise."""
    robot = load_robot(name)
    rng = np.random.default_rng(seed)
    plan = planned(robot, random_poses(robot, poses, rng), targets=TARGETS[:targets])
    campaign = simulate(plan, Truth(sigma=sigma, repeatability=np.zeros(len(robot.joints))), seed=seed)
    points = campaign.points + shake * rng.normal(size=(poses, 1, 3))
    return replace(campaign, points=points, noise_sigma=said)


def shown(campaign):
    problem = problem_of(campaign)
    return shown_by_distances(problem, stated_noise(problem))


@pytest.mark.parametrize("targets", [2, 3])
@pytest.mark.parametrize("times", [2, 5])
def test_distances_show_a_noise_that_is_stated_too_small(targets, times):
    found = shown(measured(SIGMA / times, targets=targets, poses=60))
    assert found.more
    assert found.times == pytest.approx(times, rel=0.2)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("targets", [2, 3])
def test_a_robot_that_scatters_is_no_noise_of_distances(seed, targets):
    found = shown(measured(SIGMA, seed=seed, targets=targets, shake=5e-4))
    assert not found.more
    assert found.times == pytest.approx(1.0, abs=0.3)


def test_few_bad_readings_prove_nothing_of_the_noise():
    campaign = measured(SIGMA)
    campaign.points[::10, 0] += 20 * SIGMA
    found = shown(campaign)
    assert not found.more
    assert found.times == pytest.approx(1.0, abs=0.2)


def test_one_target_has_no_distances():
    assert shown(measured(SIGMA, targets=1)) is None


@pytest.mark.parametrize("name", ["ur10", "irb120", "kr500"])
@pytest.mark.parametrize("targets", [2, 3])
def test_a_noise_stated_too_small_sits_in_no_joint(name, targets):
    found = diagnose(measured(SIGMA / 5, targets=targets, name=name, poses=60)).diagnosis
    assert found.verdict == "nothing_missing"
    assert found.noise.sigma_mm == pytest.approx(1e3 * SIGMA, rel=0.2)
    assert any(note.startswith(PROOF) for note in found.notes)


def test_the_robots_own_scatter_is_still_told_beside_a_noise_stated_too_small():
    found = diagnose(measured(SIGMA / 5, shake=2e-4, poses=60)).diagnosis
    assert found.noise.sigma_mm == pytest.approx(1e3 * SIGMA, rel=0.15)
    assert "moves all targets of a pose together" in found.causes[-1].sentence


def test_of_one_target_a_noise_stated_too_small_sits_in_no_joint():
    found = diagnose(measured(SIGMA / 5, targets=1, poses=60)).diagnosis
    (left,) = found.causes
    assert not left.where.keys()
    assert "as of a noise stated too small" in left.sentence


def test_only_what_was_tried_is_said_to_explain_nothing():
    campaign = measured(SIGMA / 5, targets=1, poses=60)
    said = diagnose(campaign).diagnosis.causes[-1].sentence
    assert "the joints, their loads and the order of measurement explains it" in said
    assert said.endswith("and record approach, time and temperature.")
    timed = replace(campaign, poses=replace(campaign.poses, time=60.0 * np.arange(60)))
    said = diagnose(timed).diagnosis.causes[-1].sentence
    assert "their loads and time explains it" in said
    assert said.endswith("and record approach and temperature.")


def test_a_noise_stated_a_little_too_small_is_a_note_and_no_structure():
    found = diagnose(measured(0.92 * SIGMA, targets=1, poses=150)).diagnosis
    assert found.verdict == "nothing_missing"
    (said,) = found.notes
    assert "larger than the noise says, without any structure: check the stated noise" in said


@pytest.mark.parametrize("targets", [1, 3])
@pytest.mark.parametrize("times", [4, 1000])
def test_a_noise_stated_far_too_large_is_told(times, targets):
    found = diagnose(measured(times * SIGMA, targets=targets)).diagnosis
    assert found.headline.startswith("Nothing is missing that shows in the stated noise, ")
    (note,) = [note for note in found.notes if note.startswith("The stated noise of")]
    assert "take sigma_mm out of [noise]" in note
    assert not any("6-D" in note for note in found.notes)


@pytest.mark.parametrize("targets", [1, 2, 3])
def test_a_noise_stated_right_is_not_doubted(targets):
    found = diagnose(measured(SIGMA, targets=targets)).diagnosis
    assert found.headline.startswith("Nothing is missing: ")
    assert found.noise.source == "stated"
    assert not found.notes


@pytest.mark.parametrize("targets", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_a_noise_that_nobody_states_is_what_distances_show_once_causes_leave_no_more(targets):
    robot = load_robot("kr500")
    plan = planned(robot, random_poses(robot, 80, np.random.default_rng(3)), targets=TARGETS[:targets])
    wheel = parse_effect("gear_eccentricity:joint=joint_1,amplitude=4e-4,phase=0.4", problem_of(plan))
    told = diagnose(simulate(plan, Truth(effects=(wheel,), sigma=SIGMA), seed=3, state_sigma=False)).diagnosis
    assert told.noise.source == "repeats"
    assert "shown by the distances between targets" in told.noise.sentence
    assert told.noise.sigma_mm == pytest.approx(1e3 * SIGMA, rel=0.15)
    assert [(cause.cause, cause.where.joint, cause.status) for cause in told.causes] == [
        ("gear_eccentricity", "joint_1", "named")
    ]
    assert told.to_json()["remainder"]["p_value"] > 1e-3


def test_distances_are_not_believed_of_a_robot_that_is_off_by_more_than_they_show():
    found = diagnose(replace(measured(None, shake=5e-4, poses=60), noise_sigma=None)).diagnosis
    assert found.noise.source == "residual"


def test_distances_are_not_believed_of_few_positions():
    """A calibration of 24 poses has numbers enough to leave no more than the instrument's noise."""
    found = diagnose(replace(measured(None, poses=24), noise_sigma=None)).diagnosis
    assert found.noise.source == "residual"


def test_what_is_only_taken_for_noise_is_said():
    found = diagnose(measured(None)).diagnosis
    assert found.noise.source == "residual"
    scatter = 1e3 * 3**0.5 * SIGMA
    told = float(found.headline.removeprefix("Nothing is missing that shows in a scatter of ").split()[0])
    assert told == pytest.approx(scatter, rel=0.15)


def test_of_two_campaigns_the_one_that_states_too_little_is_told_and_mended(tmp_path):
    sound, bold = measured(SIGMA), measured(SIGMA / 10, seed=2)
    paths = [write_campaign(tmp_path / name, c) for name, c in (("sound", sound), ("bold", bold))]
    prepared = prepare([load_campaign(path) for path in paths])
    (note,) = [note for note in prepared.notes if "Distances between targets" in note]
    assert "Distances between targets in bold, which no robot changes" in note
    assert "stated is 0.0050 mm" in note
    here = prepared.problem.campaign.poses.setup == 0
    assert prepared.covariance.sigma[here] == pytest.approx(SIGMA)
    assert prepared.covariance.sigma[~here] == pytest.approx(SIGMA, rel=0.15)
