"""Identification: to the noise and no closer, calibrated intervals, and nothing runs off."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.campaign import Target
from workbench.campaign.planned import TARGETS, planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.effects.gear_kinematic_error import GearKinematicError
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.place import Where
from workbench.identification.fit import fit, refit, start_state
from workbench.identification.heldout import folds_of, heldout
from workbench.identification.model import Model
from workbench.identification.noise import Covariance
from workbench.robot.description import load_robot
from workbench.robot.equilibrium import NoRest
from workbench.robot.kinematics import RY
from workbench.simulation.random_robot import write_random_robot
from workbench.simulation.virtual_campaign import Truth, random_geometry, simulate

SIGMA, JOINT = 3e-5, 1e-5
PLACES = np.array([target.xyz for target in TARGETS])
SHIFT = np.array([[3e-4, -2e-4, 1e-4], [-1e-4, 4e-4, 2e-4], [2e-4, 1e-4, -3e-4]])


def measured(robot="ur5", poses=120, seed=0, targets=TARGETS, judge=60, joint=0.0, six_dof=False, **columns):
    """A campaign of a robot that is off, and one without noise at other poses to judge by, from Drake."""
    robot = load_robot(robot)
    rng = np.random.default_rng(seed)
    q = random_poses(robot, poses + judge, rng)
    plan = replace(planned(robot, q[:poses], targets=targets, **columns), six_dof=six_dof)
    geometry = random_geometry(problem_of(plan).arm, rng)
    still = np.zeros(len(robot.joints))
    truth = Truth(geometry, targets=true_places(targets), sigma=SIGMA, repeatability=still + joint)
    job = problem_of(simulate(plan, truth, seed=seed))
    exact = replace(truth, sigma=0.0, repeatability=still)
    other = replace(planned(robot, q[poses:], targets=targets), setup_names=plan.setup_names)
    return job, replace(job, campaign=simulate(other, exact, seed=seed))


def true_places(targets):
    """True places: near the stated ones, at them where they are fixed."""
    stated = [target.xyz or PLACES[i] for i, target in enumerate(targets)]
    return np.array(stated) + np.where([[target.fixed] for target in targets], 0.0, SHIFT[: len(targets)])


def noise_of(job, joint=0.0):
    n_poses, n_targets = job.seen.shape
    return Covariance(np.full((n_poses, n_targets), SIGMA), np.full(job.arm.n, joint), np.ones(n_poses))


def noise_without(problem, out):
    """Leaves out the poses marked True."""
    noise = noise_of(problem)
    return replace(noise, weight=np.where(out, 0.0, noise.weight))


def fitted(job, effects=(), joint=0.0):
    return fit(Model(job, effects), start_state(job), noise_of(job, joint))


def judged(result, judge):
    """Error (3NT,) at the poses to judge by, and its covariance as the fit states it."""
    model = replace(result.model, problem=judge)
    error = model.predict(result.state) - judge.campaign.points
    ones = Covariance(np.ones(judge.seen.shape), np.zeros(judge.arm.n), np.ones(len(judge.q)))
    there = fit(model, result.state, ones, max_iterations=1)
    # both turn the instrument's frame about the middle of their own points
    apart = there.line.centre[0] - result.line.centre[0]
    J = there.J.reshape(*error.shape, -1)
    J[..., 3:6] += np.cross(np.eye(3), apart).T
    J = J.reshape(error.size, -1)
    return error.ravel(), J @ result.covariance @ J.T


def over_bound(result, judge):
    """Root mean square error over what the covariance lets one expect."""
    error, covariance = judged(result, judge)
    return np.sqrt((error @ error) / np.trace(covariance))


@pytest.mark.parametrize("seed", range(6))
def test_held_out_points_are_as_good_as_the_bound(seed):
    job, judge = measured(seed=seed)
    result = fitted(job)
    assert result.iterations < 8
    assert 0.6 < over_bound(result, judge) < 1.5
    free = 9 * 120 - result.rank
    assert result.rank == 33
    assert abs(result.chi2 - free) < 4 * np.sqrt(2 * free)


def test_predicted_points_scatter_as_their_covariance_says():
    """Over twelve campaigns, errors in the directions of the covariance are unit normal."""
    chi2 = []
    for seed in range(12):
        job, judge = measured(seed=seed, poses=60, judge=20)
        error, covariance = judged(fitted(job), judge)
        size, directions = np.linalg.eigh(covariance)
        known = size > 1e-6 * size[-1]
        assert known.sum() == 33
        chi2.append(((directions[:, known].T @ error) ** 2 / size[known]).sum())
    total = 12 * 33
    assert abs(np.sum(chi2) - total) < 4 * np.sqrt(2 * total)


def test_repeatability_common_to_a_pose_is_taken_into_account():
    ratio = []
    for seed in range(5):
        job, judge = measured(seed=seed, joint=1e-4, poses=80, judge=40)
        ratio.append(over_bound(fitted(job, joint=1e-4), judge))
    assert 0.8 < np.sqrt(np.mean(np.square(ratio))) < 1.25


@pytest.mark.parametrize("count", [1, 2, 3])
def test_unknown_targets_are_found(count):
    job, judge = measured(targets=tuple(Target(f"T{i}") for i in range(count)), seed=count)
    result = fitted(job)
    assert 0.6 < over_bound(result, judge) < 1.5
    assert np.abs(result.state.targets[0] - true_places(job.campaign.targets)).max() < 5e-3


def test_fixed_targets_stay_and_free_ones_move():
    targets = (replace(TARGETS[0], fixed=True), *TARGETS[1:])
    job, judge = measured(targets=targets)
    result = fitted(job)
    assert np.array_equal(result.state.targets[0, 0], PLACES[0])
    assert not [name for name in result.columns.names if "T1" in name]
    assert (result.state.targets[0, 1:] != PLACES[1:]).all()
    assert 0.6 < over_bound(result, judge) < 1.5


def test_every_setup_has_its_frame_and_its_targets():
    job, _ = measured(setup=["left", "right"] * 60, judge=1)
    result = fitted(job)
    assert result.state.R.shape == (2, 3, 3)
    assert result.rank == 33 + 6 + 9
    assert abs(result.chi2 / (9 * 120 - result.rank) - 1) < 4 * np.sqrt(2 / 1000)
    assert np.linalg.norm(result.state.t[0] - result.state.t[1]) > 0.1


def test_points_that_were_not_seen_leave_the_rest_as_good():
    job, judge = measured(seed=7)
    rng = np.random.default_rng(7)
    hidden = rng.random(job.seen.shape) < 0.3
    hidden[np.arange(120), rng.integers(0, 3, 120)] = False
    points = np.where(hidden[..., None], np.nan, job.campaign.points)
    result = fitted(replace(job, campaign=replace(job.campaign, points=points)))
    assert np.array_equal(np.isnan(result.residual[..., 0]), hidden)
    assert abs(result.chi2 / (3 * (~hidden).sum() - result.rank) - 1) < 4 * np.sqrt(2 / 700)
    assert 0.6 < over_bound(result, judge) < 1.5
    assert np.isnan(heldout(result)[hidden]).all()


@pytest.mark.parametrize("stated", [True, False])
def test_six_dof_measurements_count_six(stated):
    targets = TARGETS if stated else tuple(Target(target.name) for target in TARGETS)
    job, judge = measured(six_dof=True, targets=targets, seed=1)
    result = fitted(job)
    assert result.J.shape[1] == 6
    assert abs(result.chi2 / (6 * 120 - 30) - 1) < 4 * np.sqrt(2 / 690)
    error = Model(judge).predict(result.state) - judge.campaign.points
    assert np.sqrt(np.mean(error**2)) < 0.4 * SIGMA


def test_targets_on_the_base_and_on_a_link():
    targets = (
        TARGETS[0],
        Target("B", (0.6, 0.3, 0.2), on="base"),
        Target("L", (0.1, 0.05, 0.1), on="link_3"),
    )
    job, judge = measured(targets=targets, seed=2)
    result = fitted(job)
    assert abs(result.chi2 / (9 * 120 - result.rank) - 1) < 4 * np.sqrt(2 / 1040)
    assert 0.6 < over_bound(result, judge) < 1.5


@pytest.mark.parametrize(("kind", "rank"), [("7R", 4 * 7 + 9), ("PRRR", 2 + 4 * 3 + 9)])
def test_other_robots(tmp_path, kind, rank):
    robot = write_random_robot(tmp_path, 5, kind, elastic=False)
    job, judge = measured(robot, seed=3)
    result = fitted(job)
    assert result.rank == rank
    assert abs(result.chi2 / (9 * 120 - rank) - 1) < 4 * np.sqrt(2 / 1040)
    assert 0.6 < over_bound(result, judge) < 1.5


def test_compliances_are_found_and_joint_1_says_that_it_is_not_seen():
    robot = load_robot("kr500")
    heavy = {"heavy": (250.0, (0.1, 0.0, 0.2))}
    q = random_poses(robot, 60, np.random.default_rng(4))
    plan = planned(robot, q, payloads=heavy, payload=["", "heavy"] * 30)
    sites = JointCompliance.each(problem_of(plan))
    truth = Truth(effects=((sites[2], np.array([0.3])),), sigma=SIGMA, repeatability=np.zeros(6))
    result = fitted(problem_of(simulate(plan, truth, seed=4)), tuple(sites))
    names = [f"joint_compliance/{name}" for name in robot.joint_names]
    values = np.array([result.value(name) for name in names])
    std = np.array([result.std(name) for name in names])
    assert (np.abs(values - [0, 0, 0.3, 0, 0, 0]) < 4 * std).all()
    assert std[2] < 0.02
    # gravity makes no torque about a vertical axis
    assert std[0] > 1.0


def test_fitted_numbers_have_names():
    job, _ = measured(judge=1, setup=["left", "right"] * 60)
    order = [GearKinematicError(Where(joint="elbow_joint", order=k)) for k in (40.0, 83.5)]
    result = fitted(job, (*JointCompliance.each(job)[:2], *order))
    assert len(set(result.columns.names)) == len(result.columns.names)
    for p, name in enumerate(result.columns.names):
        assert result.columns.index(name) == p
        assert result.std(name) ** 2 == pytest.approx(result.covariance[p, p])
    assert result.value("target/right/T2/z") == result.state.targets[1, 1, 2]
    elbow = job.arm.names.index("elbow_joint") + 1
    assert result.value("geometry/elbow_joint/ry") == result.state.geometry[elbow, RY]
    assert result.value("gear_kinematic_error/elbow_joint/83.5/cos") == result.state.values[3][1]
    (one,) = result.state.values[1]
    assert result.value(f"joint_compliance/{job.arm.names[1]}") == one
    for wrong, said in [
        ("gear_kinematic_error/elbow_joint", "names 4"),
        ("gear_kinematic_error/elbow", "names 0"),
        ("frame/left/tx", "is a motion"),
    ]:
        with pytest.raises(KeyError, match=said):
            result.value(wrong)


def test_refit_starts_from_what_is_known():
    job, _ = measured(judge=1)
    result = fitted(job)
    again = refit(result, ())
    assert again.iterations <= 2
    assert abs(again.chi2 - result.chi2) < 1e-2


def test_weights_leave_a_pose_out():
    job, _ = measured(judge=1, seed=9)
    points = job.campaign.points.copy()
    points[10] += 5e-3
    spoilt = replace(job, campaign=replace(job.campaign, points=points))
    out = np.arange(120) == 10
    one = fit(Model(spoilt), start_state(spoilt), noise_without(job, out))
    points = points.copy()
    points[10] += 1.0
    far = replace(job, campaign=replace(job.campaign, points=points))
    two = fit(Model(far), one.state, noise_without(job, out))
    assert np.abs(one.state.geometry - two.state.geometry).max() < 1e-9
    assert np.linalg.norm(one.residual[10]) > 5e-3


def test_a_hand_that_never_turns_stays_near_the_stated_nominal():
    """As the MA1400's campaign: one target, one orientation, so frame and target are one."""
    robot = load_robot("ur5")
    rng = np.random.default_rng(11)
    q = np.tile(np.array([0.3, -1.2, 1.4, -0.4, 1.3, 0.2]), (100, 1))
    q[:, 1:3] += rng.uniform(-0.6, 0.6, (100, 2))
    q[:, 3] = 0.2 - q[:, 1] - q[:, 2]  # axes 2, 3, 4 are parallel: the hand keeps its tilt
    plan = planned(robot, q, targets=TARGETS[:1])
    geometry = random_geometry(problem_of(plan).arm, rng, 5e-4, 5e-4)
    job = problem_of(simulate(plan, Truth(geometry, sigma=SIGMA, repeatability=np.zeros(6)), seed=11))
    result = fitted(job)
    assert np.abs(result.state.targets[0, 0] - PLACES[0]).max() < 2e-3
    assert np.abs(result.state.geometry[:, :3]).max() < 2e-3
    assert np.abs(result.state.geometry[:, 3:]).max() < 4e-3
    assert result.rank < 20
    assert abs(result.chi2 / (300 - result.rank) - 1) < 4 * np.sqrt(2 / 280)


@pytest.mark.parametrize("count", [1, 3])
def test_held_out_residuals_equal_refits_without_the_fold(count):
    job, _ = measured(poses=60, targets=TARGETS[:count], seed=12, judge=1)
    result = fitted(job)
    quick = heldout(result, folds=5, seed=3)
    fold = folds_of(job, 5, seed=3)
    assert np.bincount(fold).tolist() == [12] * 5
    slow = np.empty_like(quick)
    for f in range(5):
        other = fit(Model(job), result.state, noise_without(job, fold == f), tolerance=1e-4)
        slow[fold == f] = other.residual[fold == f]
    assert np.abs(quick - slow).max() < 0.01 * np.sqrt(np.mean(slow**2))
    assert abs(np.mean(quick**2) / np.mean(slow**2) - 1) < 0.01
    assert np.mean(quick**2) > np.mean(result.residual**2)


def test_one_pose_less_leaves_the_others_where_they_are_held_out():
    job, _ = measured(poses=60, targets=TARGETS[:1], seed=12, judge=1)
    before = folds_of(job, 5, seed=3)
    rest = np.delete(np.arange(60), 20)
    after = folds_of(problem_of(job.campaign.some(rest)), 5, seed=3)
    assert (after != before[rest]).sum() <= 5
    assert (folds_of(job, 5, seed=4) != before).sum() > 30


def test_loads_and_repeats_of_a_pose_are_held_out_together():
    job, _ = measured(poses=40, judge=1, seed=13)
    c = job.campaign
    twice = np.repeat(np.arange(40), 2)
    points = c.points[twice] + SIGMA * np.random.default_rng(0).normal(size=(80, 3, 3))
    double = problem_of(replace(planned(job.robot, c.poses.q[twice]), points=points, shots=c.shots[twice]))
    result = fitted(double)
    out = heldout(result, folds=40)
    left = fit(Model(double), result.state, noise_without(double, double.positions == 3), tolerance=1e-4)
    assert np.abs(out - left.residual)[double.positions == 3].max() < 1e-6


@pytest.mark.parametrize("positions", [1, 3])
def test_set_ups_of_few_positions_are_held_out_load_by_load(positions):
    """Without one of these positions nothing tells where the instrument stands from where the targets sit:
    what was held out was kilometres off."""
    rng = np.random.default_rng(4)
    robot = load_robot("kr500")
    q = np.repeat(random_poses(robot, 10 * positions, rng), 4, axis=0)
    wrench = np.concatenate([rng.normal(0, 800.0, (len(q), 3)), np.zeros((len(q), 3))], axis=1)
    plan = planned(robot, q, targets=TARGETS, wrench=wrench)
    setup = np.repeat(np.arange(10), 4 * positions)
    plan = replace(plan.with_poses(setup=setup), setup_names=tuple(f"s{k}" for k in range(10)))
    job = problem_of(simulate(plan, Truth(sigma=SIGMA, repeatability=np.zeros(6)), seed=2))
    out = heldout(fitted(job), folds=10)
    assert np.sqrt(np.mean(out**2)) < 2 * SIGMA


def test_what_another_effect_alone_held_up_is_fitted_anew():
    """With a joint far too soft to bear the arm, as one is whose counterpart has gone from the model, there
    is no place to start from: the robot as it is takes its place."""
    job, _ = measured("irb120", poses=20, judge=1)
    soft = JointCompliance(Where(joint="joint_2"))
    both = fit(Model(job, (soft, JointCompliance(Where(joint="joint_3")))))
    lost = replace(both, state=replace(both.state, values=(np.array([5.0]), np.array([0.0]))))
    with pytest.raises(NoRest):
        lost.model.loaded(lost.state)
    (alone,), (found,) = (refit(one, [soft]).state.values for one in (both, lost))
    assert found == pytest.approx(alone, abs=1e-8)


def test_two_lines_of_a_joint_stay_as_they_were_fitted_in_a_fit_that_goes_on():
    job, _ = measured(poses=60, judge=1)
    joint = job.arm.names[1]
    lines = tuple(GearKinematicError(Where(joint=joint, order=order)) for order in (7.0, 31.0))
    model = Model(job, lines)
    state = replace(start_state(job), values=(np.array([3e-4, 0.0]), np.array([0.0, -2e-4])))
    shown = model.predict(state)
    job = replace(job, campaign=replace(job.campaign, points=shown))
    once = fitted(job, lines)
    again = refit(once, lines)
    assert again.converged
    for before, after in zip(once.state.values, again.state.values, strict=True):
        np.testing.assert_allclose(after, before, atol=1e-6)
