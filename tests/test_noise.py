"""Noise: recovered from repeats, held against what is stated, not claimed where nothing shows it."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.campaign.planned import TARGETS, planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.diagnosis import run
from workbench.diagnosis.noise.noise_choice import choose, from_residual
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.search.competition import compete
from workbench.effects.records import parse_effect
from workbench.identification.fit import fit, start_state
from workbench.identification.model import Model
from workbench.identification.noise import (
    Covariance,
    measure_noise,
    repeat_chi2,
    stated_noise,
    whitener,
)
from workbench.identification.repeats import repeat_groups, scatter_of_repeats
from workbench.robot.description import load_robot
from workbench.simulation.virtual_campaign import Truth, simulate
from workbench.studies.blind.cases import draw_case
from workbench.studies.followup.case import first_campaign

SIGMA, JOINT = 3e-5, 4e-5


def measured(seed=0, poses=10, returns=5, shots=3, once=0, sigma=SIGMA, joint=JOINT, **said):
    """A UR5 (rigid) measured at poses that are returned to, and at others only once."""
    robot = load_robot("ur5")
    rng = np.random.default_rng(seed)
    q = random_poses(robot, poses + once, rng)
    q = np.concatenate([np.repeat(q[:poses], returns, axis=0), q[poses:]])
    q = q[rng.permutation(len(q))]
    truth = Truth(sigma=sigma, repeatability=np.full(6, joint))
    return problem_of(simulate(planned(robot, q), truth, seed=seed, shots=shots, **said))


def started(job):
    """The problem's derivatives after registration."""
    return Model(job).linearise(start_state(job))


def axial_of(job):
    """(N, 3T, n) motion of the points per joint, in the instrument's frame."""
    return started(job).direct[:, :, job.arm.axial]


def without(job, poses, target):
    """The same campaign, one target not seen in some poses."""
    c = job.campaign
    points, shots = c.points.copy(), c.shots.copy()
    points[poses, target], shots[poses, target] = np.nan, 0
    return replace(job, campaign=replace(c, points=points, shots=shots))


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_repeats_and_shots_give_both_parts(seed):
    job = measured(seed)
    found = measure_noise(job, axial_of(job))
    # 900 degrees of freedom of the shots; 40 returns of six joints
    assert abs(found.sigma / SIGMA - 1) < 4 / np.sqrt(2 * 900)
    assert abs(found.joint[0] / JOINT - 1) < 4 / np.sqrt(2 * 240)
    assert np.ptp(found.joint) == 0
    assert found.dof == 10 * 4 * 9 + 50 * 2 * 9


@pytest.mark.parametrize("seed", [0, 1])
def test_repeats_alone_tell_the_parts_by_what_targets_share(seed):
    job = measured(seed, shots=1)
    found = measure_noise(job, axial_of(job))
    # three targets have nine rows, six of which the joints can move
    assert abs(found.sigma / SIGMA - 1) < 4 / np.sqrt(2 * 3 * 40)
    assert abs(found.joint[0] / JOINT - 1) < 0.25


def test_a_robot_that_repeats_exactly_gets_no_repeatability():
    job = measured(joint=0.0)
    found = measure_noise(job, axial_of(job))
    assert not found.joint.any()
    assert abs(found.total / (SIGMA / np.sqrt(3)) - 1) < 4 / np.sqrt(2 * 360)


def test_repeats_count_among_many_poses_measured_once():
    job = measured(once=60)
    found = measure_noise(job, axial_of(job))
    assert found.dof == 10 * 4 * 9 + 110 * 2 * 9
    assert abs(found.joint[0] / JOINT - 1) < 4 / np.sqrt(2 * 240)


def test_a_joint_repeats_as_its_data_say_against_the_others():
    job = measured(2)
    data = [replace(joint, data=joint.data.model_copy(update={"repeatability": (k + 1) * 1e-6}))
            for k, joint in enumerate(job.robot.joints)]  # fmt: skip
    other = replace(job, robot=replace(job.robot, joints=tuple(data)))
    found = measure_noise(other, axial_of(job))
    assert np.allclose(found.joint / found.joint[0], np.arange(1, 7))


def test_without_repeats_nothing_is_measured():
    job = measured(poses=30, returns=1, state_sigma=False)
    assert measure_noise(job, axial_of(job)) is None
    noise, said, notes = choose(job, started(job))
    assert said.source == "residual"
    assert not notes
    assert np.ptp(noise.sigma) == 0
    assert stated_noise(job) is None


def test_the_side_of_approach_and_the_load_make_other_poses():
    job = measured(poses=4)
    groups = repeat_groups(job)
    assert sorted(np.bincount(groups)) == [5, 5, 5, 5]
    side = np.ones(job.q.shape)
    side[::2] = -1
    other = replace(job, campaign=job.campaign.with_poses(side=side))
    assert len(np.unique(repeat_groups(other))) > 4
    wrench = np.zeros((20, 6))
    wrench[0, 2] = 50.0
    other = replace(job, campaign=job.campaign.with_poses(wrench=wrench))
    assert len(np.unique(repeat_groups(other))) == 5


def test_stated_noise_that_repeats_confirm_is_kept():
    job = measured(joint=0.0)
    noise, said, notes = choose(job, started(job))
    assert said.source == "stated"
    assert "repeats agree" in said.sentence
    assert not notes
    assert np.allclose(noise.sigma, SIGMA / np.sqrt(3))
    assert noise.dof == np.inf


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_stated_noise_that_repeats_contradict_is_replaced_and_told(factor):
    job = measured(joint=0.0)
    job = replace(job, campaign=replace(job.campaign, noise_sigma=factor * SIGMA))
    noise, said, notes = choose(job, started(job))
    assert said.source == "repeats"
    assert "the measured noise is used" in notes[0]
    assert f"{factor * SIGMA / np.sqrt(3) * 1e3:.4f} mm" in notes[0]
    assert abs(noise.sigma[0, 0] / (SIGMA / np.sqrt(3)) - 1) < 0.1
    assert np.isfinite(noise.dof)


def hours(job, motion):
    """The same campaign over eight hours, 20 to 26 °C, its points moved by motion(points, share of the time,
    warmth [K])."""
    c, count = job.campaign, len(job.q)
    share = np.linspace(0.0, 1.0, count)
    warmth = 6 * np.sin(np.pi * share) ** 2
    poses = job.campaign.with_poses(time=8 * 3600 * share, temperature=20 + warmth).poses
    points = c.points + motion(c.points, share[:, None, None], warmth[:, None, None])
    return replace(job, campaign=replace(c, poses=poses, points=points))


@pytest.mark.parametrize(
    "motion",
    [
        lambda points, share, warmth: 3e-4 * np.array([0.5, -1.0, 0.3]) * share,
        lambda points, share, warmth: 3e-4 * np.array([0.5, -1.0, 0.3]) * (1 - np.exp(-share / 0.15)),
        lambda points, share, warmth: 1.2e-5 * warmth * (points - np.array([0.2, 0.1, 0.0])),
        lambda points, share, warmth: 2e-4 * share * np.cross([0.0, 0.6, 1.0], points),
    ],
    ids=["drift", "settles", "grows", "turns"],
)
def test_what_repeats_drift_by_is_no_noise(motion):
    """Hours apart they differ by more than the instrument and the robot scatter by."""
    job = hours(measured(), motion)
    found = measure_noise(job, axial_of(job))
    assert found.sigma == pytest.approx(SIGMA, rel=0.1)
    assert found.joint == pytest.approx(np.full(6, JOINT), rel=0.25)
    still = hours(measured(joint=0.0), motion)
    noise, said, notes = choose(still, started(still))
    assert (said.source, notes) == ("stated", [])
    assert np.allclose(noise.sigma, SIGMA / np.sqrt(3))


@pytest.mark.parametrize("seed", range(4))
def test_what_few_repeats_drift_by_is_no_noise(seed):
    """Of a dozen poses that were returned to once, a large drift explains more than half in any order."""

    def crept(points, share, warmth):
        return 6e-4 * np.array([0.1, 0.9, -0.4]) * (1 - np.exp(-share / 0.9))

    job = hours(measured(seed, poses=12, returns=2, shots=1, once=30), crept)
    found, still = (measure_noise(one, axial_of(one)) for one in (job, measured(seed, 12, 2, 1, 30)))
    assert found.total == pytest.approx(still.total, rel=0.2)


@pytest.mark.parametrize(("poses", "returns"), [(10, 5), (12, 2)])
@pytest.mark.parametrize("seed", range(12))
def test_scatter_that_does_not_pass_slowly_stays_noise(seed, poses, returns):
    """Nothing is taken out where nothing drifts, however much time is on record."""
    job = measured(seed, poses, returns)
    timed = hours(job, lambda points, share, warmth: 0.0)
    for one, other in zip(scatter_of_repeats(timed), scatter_of_repeats(job), strict=True):
        assert np.array_equal(one, other)


def test_repeatability_that_the_statement_forgets_is_found():
    job = measured(joint=JOINT)
    noise, said, notes = choose(job, started(job))
    assert said.source == "repeats"
    assert notes
    assert said.repeatability_mm is None or said.repeatability_mm > 0.01
    assert abs(noise.joint[0] / JOINT - 1) < 0.25


@pytest.mark.parametrize("seed", [5, 6, 7])
def test_repeats_whitened_by_the_true_noise_are_chi_square(seed):
    job = measured(seed)
    true = Covariance(np.full((50, 3), SIGMA / np.sqrt(3)), np.full(6, JOINT), np.ones(50))
    chi2, dof = repeat_chi2(job, true, axial_of(job))
    assert dof == 360
    assert abs(chi2 / dof - 1) < 4 * np.sqrt(2 / dof)


def test_targets_that_were_never_seen_in_a_group_raise_no_warning():
    job = measured()
    poses = np.flatnonzero(repeat_groups(job) == 0)
    hidden = without(without(job, poses, 1), [poses[0]], 0)
    found = measure_noise(hidden, axial_of(job))
    # a target that a group never shows says nothing; one that a pose misses costs three of its numbers
    assert found.dof == 360 - 12 - 3 + 50 * 2 * 9
    assert abs(found.sigma / SIGMA - 1) < 0.1
    assert abs(found.joint[0] / JOINT - 1) < 0.25
    choose(hidden, started(hidden))


def test_equal_repeats_break_nothing():
    job = measured(sigma=0.0, joint=0.0, shots=1)
    assert measure_noise(job, axial_of(job)).total <= 1e-9
    job = replace(job, campaign=replace(job.campaign, noise_sigma=SIGMA))
    assert "measured noise is used" in choose(job, started(job))[2][0]


def test_the_whitener_makes_unit_noise_of_what_was_seen():
    job = without(measured(), [3, 4], 2)
    noise = Covariance(np.full((50, 3), SIGMA), np.full(6, JOINT), np.linspace(0, 1, 50))
    axial = axial_of(job)
    W = whitener(job, noise, axial, None)
    J = np.where(np.repeat(job.seen, 3, axis=1)[..., None], axial, 0.0) * JOINT
    C = J @ J.transpose(0, 2, 1) + SIGMA**2 * np.eye(9)
    one = W @ C @ W.transpose(0, 2, 1)
    expected = np.eye(9) * np.repeat(job.seen, 3, axis=1)[:, None] * noise.weight[:, None, None] ** 2
    assert np.abs(one - expected).max() < 1e-9
    assert not W[3, :, 6:].any()


@pytest.mark.parametrize("seed", [0, 1])
def test_noise_from_the_residual_has_both_parts(seed):
    job = measured(seed, poses=120, returns=1, shots=1, state_sigma=False)
    guess = choose(job, started(job))[0]
    noise, said = from_residual(fit(Model(job), start_state(job), guess))
    assert said.source == "residual"
    assert abs(noise.sigma[0, 0] / SIGMA - 1) < 0.15
    assert abs(noise.joint[0] / JOINT - 1) < 0.2
    shared = JOINT * np.sqrt(np.mean((started(job).by_joint ** 2).sum(axis=2)))
    assert said.repeatability_mm == pytest.approx(1e3 * shared, rel=0.2)
    assert f"and {said.repeatability_mm:.4f} mm per axis that the points of a pose share" in said.sentence
    assert said.alone_mm == pytest.approx(np.hypot(said.sigma_mm, said.repeatability_mm))


def test_noise_from_the_residual_of_one_target_is_one_sigma():
    robot = load_robot("ur5")
    rng = np.random.default_rng(3)
    plan = planned(robot, random_poses(robot, 120, rng), targets=measured().campaign.targets[:1])
    job = problem_of(simulate(plan, Truth(sigma=SIGMA, repeatability=np.zeros(6)), state_sigma=False))
    noise, _ = from_residual(fit(Model(job), start_state(job), choose(job, started(job))[0]))
    assert abs(noise.sigma[0, 0] / SIGMA - 1) < 0.15
    assert not noise.joint.any()


def test_a_noise_that_the_residual_hardly_shows_ends_the_search_for_it(tmp_path):
    """Variances that were tried without end made the covariance singular, and an honest robot was refused."""
    campaign = first_campaign(draw_case("lost_motion/16", 5, tmp_path).campaign)
    assert np.isfinite(prepare(campaign).noise.sigma_mm)


def with_a_wrong_ratio(sigma, targets=3):
    """A UR5 (data sheet: RP 0.1 mm) at forty poses, and at two of them again."""
    robot = load_robot("ur5")
    q = random_poses(robot, 40, np.random.default_rng(7))
    plan = planned(robot, np.concatenate([q, q[:2]]), targets=TARGETS[:targets])
    ratio = parse_effect("gear_ratio:joint=elbow_joint,relative=1e-3", problem_of(plan))
    return simulate(plan, Truth(sigma=sigma, effects=(ratio,)), seed=7)


def competed(campaign, stated):
    prepared = prepare(replace(campaign, sigma=None, noise_sigma=stated))
    return prepared.noise, compete(prepared, run.testable(prepared.problem)[0])


def test_a_noise_from_few_repeats_may_be_off_without_a_misfit():
    """Eighteen degrees of freedom know it to 17 %."""
    noise, found = competed(with_a_wrong_ratio(SIGMA), None)
    assert (noise.source, noise.sigma_mm) == ("repeats", pytest.approx(0.022, abs=0.001))
    assert not found.misfit


@pytest.mark.parametrize(("times", "misfit"), [pytest.param(1.3, False, marks=pytest.mark.slow), (3.0, True)])
def test_what_a_robot_of_its_data_sheet_adds_to_a_stated_noise_is_no_misfit(times, misfit):
    """RP 0.09 mm is its repeatability, 0.3 mm is something else. (Of one target: distances would show it.)"""
    found = competed(with_a_wrong_ratio(times * SIGMA, targets=1), SIGMA)[1]
    assert found.misfit == misfit


@pytest.mark.parametrize("seed", range(4))
def test_a_target_that_one_of_the_repeats_shows_says_nothing(seed):
    """Its deviation of zero had counted as exact: of a target on the base that was seen now and then, a noise
    of nothing."""
    job = measured(seed, shots=1)
    groups = [np.flatnonzero(repeat_groups(job) == group) for group in range(10)]
    hidden = job
    for target in (1, 2):
        hidden = without(hidden, np.concatenate([members[1:] for members in groups]), target)
    alone = without(without(job, np.arange(50), 1), np.arange(50), 2)
    found, right = (measure_noise(one, axial_of(job)) for one in (hidden, alone))
    assert found.dof == right.dof == 10 * 4 * 3
    assert found.sigma == pytest.approx(right.sigma, rel=1e-6)
    assert found.joint == pytest.approx(right.joint, rel=1e-6)
