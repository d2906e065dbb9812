"""What moves a pose's targets together, from pose to pose, is scatter and no cause."""

import re
from dataclasses import replace

import diagnosis_cases as cases
import numpy as np
import pytest

from workbench import Truth, diagnose, load_robot, planned, random_poses, simulate
from workbench.campaign import Target
from workbench.diagnosis import candidates
from workbench.diagnosis.found import Stage
from workbench.diagnosis.noise.scatter import beyond_all, with_scatter
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.telling.headline import Errors, headline
from workbench.diagnosis.telling.power import visible_mm, wandering_mm
from workbench.effects.base import UNKNOWN
from workbench.measurement.sweep import sweep

SIGMA, SHIFT = 1.5e-5, 1.6e-5


def measured(seed, shift=SHIFT, poses=45, said=SIGMA, sigma=SIGMA):
    """A robot that nobody knows the repeatability of, its three targets moved together from pose to pose."""
    robot = load_robot("lrmate200id")
    rng = np.random.default_rng(seed)
    plan = planned(robot, random_poses(robot, poses, rng))
    still = np.zeros(len(robot.joints))
    campaign = simulate(plan, Truth(sigma=sigma, repeatability=still), seed=seed)
    moved = shift * rng.normal(size=(poses, 1, 3))
    return replace(campaign, points=campaign.points + moved, noise_sigma=said)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_scatter_of_a_whole_pose_is_found_in_few_poses(seed):
    geometry = prepare(measured(seed)).geometry
    shift, turn = with_scatter(geometry, geometry.noise).body
    assert shift == pytest.approx(SHIFT, rel=0.25)
    assert turn < 1e-4  # rad: next to nothing over 0.1 m between the targets


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_none_is_found_where_there_is_none(seed):
    geometry = prepare(measured(seed, shift=0.0)).geometry
    assert with_scatter(geometry, geometry.noise).body == (0.0, 0.0)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_scatter_is_found_where_all_of_it_was_stated_as_the_instruments(seed):
    """The size of the noise is right then, and what targets of a pose share is not."""
    geometry = prepare(measured(seed, poses=90, said=float(np.hypot(SIGMA, SHIFT)))).geometry
    shift, _ = with_scatter(geometry, geometry.noise).body
    assert SHIFT / 2 < shift < SHIFT


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_scatter_is_told_and_no_cause_named(seed):
    found = diagnose(measured(seed)).diagnosis
    assert not [f for f in found.causes if f.cause != UNKNOWN and f.status == "named"]
    assert found.verdict == "unknown"
    assert "moves all targets of a pose together" in found.causes[-1].sentence


def _repeating(seed, spread, poses=90):
    """A robot each joint of which repeats to its part of spread (6,) [rad], and how far they do beyond it."""
    robot = load_robot("irb120")
    plan = planned(robot, random_poses(robot, poses, np.random.default_rng(seed)))
    truth = Truth(sigma=1e-5, repeatability=np.asarray(spread))
    geometry = prepare(replace(simulate(plan, truth, seed=seed), noise_sigma=1e-5)).geometry
    base = replace(geometry.noise, joint=np.zeros(6))
    noise = with_scatter(geometry, base)
    return noise, beyond_all(replace(geometry, noise=noise), base)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_robot_that_repeats_is_no_joint_that_scatters(seed):
    """As wrists do by more than the first joints, which have the longer arm."""
    noise, beyond = _repeating(seed, [9e-6] * 3 + [1.6e-5] * 3)
    assert not beyond.any()
    assert noise.joint == pytest.approx(np.full(6, 1e-5), rel=0.35)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_joint_that_scatters_more_is_told_from_the_others(seed):
    _, beyond = _repeating(seed, [8e-6, 8e-6, 6e-5, 8e-6, 8e-6, 8e-6])
    assert np.flatnonzero(beyond).tolist() == [2]
    assert beyond[2] == pytest.approx(6e-5, rel=0.25)


def _told_of(points, sigma, plan):
    """In which joint the unknown sits that a diagnosis of points (N, T, 3) tells under a stated noise, if in
    any."""
    causes = diagnose(replace(plan, points=points, noise_sigma=sigma)).diagnosis.causes
    assert [one.cause for one in causes] in ([], [UNKNOWN])
    return causes[0].where.joint if causes else None


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_depth_of_a_camera_is_no_joint_that_scatters(seed):
    """Three times the noise along its sight, and with the square of the distance: what of it looks like the
    scatter of a joint is clear, but next to nothing of it."""
    robot, rng = load_robot("kr500"), np.random.default_rng(seed)
    exact = simulate(planned(robot, random_poses(robot, 80, rng)), Truth(), seed=seed)
    far = np.linalg.norm(exact.points, axis=2, keepdims=True)
    sight = exact.points.mean(axis=(0, 1)) / np.linalg.norm(exact.points.mean(axis=(0, 1)))
    error = SIGMA * rng.normal(size=exact.points.shape) * (far / far.mean()) ** 2
    error += 2 * (error @ sight)[..., None] * sight
    assert _told_of(exact.points + error, 1.9 * SIGMA, exact) is None


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_joint_that_most_of_the_scatter_comes_from_is_told(seed):
    robot, rng = load_robot("kr500"), np.random.default_rng(seed)
    truth = Truth(sigma=SIGMA, repeatability=np.where(np.arange(6) == 1, 4e-5, robot.repeatability))
    measured = simulate(planned(robot, random_poses(robot, 80, rng)), truth, seed=seed)
    assert _told_of(measured.points, SIGMA, measured) == "joint_2"


@pytest.mark.parametrize("rounding", [1e-17, 1e-13, 1e-9, 1e-3])
def test_joints_that_move_no_point_decide_nothing(rounding):
    """A sweep of joint 2, its target on link_2: the wrist moves it by rounding alone, another on every
    machine: that is not in the answer."""
    target = Target("T", (0.0, -0.25, 0.95), "link_2")
    plan = sweep(load_robot("rx170"), "joint_2", np.zeros(6), (-0.9, 0.9), 400, target)
    bent = np.where(np.arange(6) == 1, 6e-5 * np.sin(123.4 * plan.poses.q[:, 1:2]), 0.0)
    truth = Truth(joints=lambda job: bent, sigma=1e-6, repeatability=np.zeros(6))
    geometry = prepare(simulate(plan, truth, seed=1)).geometry
    wrist = geometry.model.problem.arm.axial[2:]
    moved = geometry.line.direct.copy()
    moved[:, :, wrist] = 0.0
    fitted = replace(geometry, line=replace(geometry.line, loaded=moved))
    without = with_scatter(fitted, geometry.noise)
    least = rounding * geometry.noise.usual
    moved[:, :, wrist] = least * np.random.default_rng(0).normal(size=(*moved.shape[:2], 4))
    noise = with_scatter(fitted, geometry.noise)
    assert noise.joint[1] == pytest.approx(6e-5 / np.sqrt(2), rel=0.15)
    assert noise.joint == pytest.approx(without.joint, rel=1e-9)


def test_scatter_as_small_as_a_robots_is_its_repeatability_and_no_cause():
    found = diagnose(measured(0, shift=8e-6)).diagnosis
    assert found.verdict == "nothing_missing"
    assert not found.causes
    (note,) = [note for note in found.notes if "its data sheet says 0.02 mm" in note]
    assert "Play looks the same where the sides of approach are not recorded." in note
    repeats_to = float(re.search(r"repeats to (\S+) mm", note)[1])
    assert repeats_to == pytest.approx(3.62e3 * 8e-6, rel=0.3)  # ISO 9283 RP of normal deviations


def test_the_headline_says_how_the_robot_seems_to_repeat():
    stages = [Stage("nominal", 0, 1.0, 1.0, 1.0, 1.0), Stage("geometry", 18, 0.03, 0.03, 0.03, 0.03)]
    said = headline(
        "nothing_missing", [], Errors(stages, stages[1], 0.03, 0.03, 0.008, 0.03), repeatability_mm=0.043
    )
    assert said.startswith("Nothing is missing, though the robot seems to repeat to 0.043 mm only: geometry ")
    assert "an error of 0.008 mm RMS beyond it would have shown. " in said


def test_what_wanders_has_to_be_larger_to_show():
    stages = [Stage("nominal", 0, 1.0, 1.0, 1.0, 1.0), Stage("geometry", 18, 0.03, 0.03, 0.03, 0.03)]
    errors = Errors(stages, stages[1], 0.03, 0.03, 0.008, 0.03, wandering=0.013)
    said = "an error of 0.008 mm RMS beyond it would have shown (0.013 mm where it wanders in time). "
    assert said in headline("nothing_missing", [], errors)
    prepared = prepare(measured(0))
    causes, _ = candidates.testable(prepared.problem)
    usual = visible_mm(prepared.geometry, causes)
    assert 1.3 * usual < wandering_mm(prepared.geometry, causes) < 2 * usual


def test_scatter_that_no_robot_makes_is_left():
    found = diagnose(measured(0, shift=3e-5)).diagnosis
    assert [cause.cause for cause in found.causes] == [UNKNOWN]


def test_scatter_that_repeats_do_not_show_is_left():
    """The same shift whenever a pose is visited again: no repeatability, though as small."""
    exact = measured(0, shift=8e-6, sigma=0.0).some(np.r_[np.arange(45), np.arange(0, 45, 3)])
    noise = SIGMA * np.random.default_rng(7).normal(size=exact.points.shape)
    campaign = replace(exact, points=exact.points + noise, noise_sigma=SIGMA)
    assert [cause.cause for cause in diagnose(campaign).diagnosis.causes] == [UNKNOWN]


@pytest.mark.parametrize(("turns", "seed"), [(2.0, 1), (3.0, 0)])
def test_a_base_that_wanders_does_not_hide_in_the_scatter_that_it_makes(turns, seed):
    """One target, few poses: beside the scatter that is left without it, it explains next to nothing."""
    share, rng = np.linspace(0.0, 1.0, 50), np.random.default_rng(seed)
    phase, way = rng.uniform(0, 6, 3), rng.normal(size=3)
    wanders = 1e-4 * way / np.linalg.norm(way) * np.sin(2 * np.pi * turns * share[:, None] + phase)
    campaign = cases.measured(
        "kr120",
        loads=(),
        poses=50,
        seed=seed,
        targets=1,
        time=2205 * share,
        motion=lambda _: dict(enumerate(wanders.T)),
    )
    assert cases.named(diagnose(campaign).diagnosis) == {("drift", ""): "named"}
