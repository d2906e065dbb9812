"""Drive torques out of Drake: their noise is told from what a wrong load makes of them."""

from dataclasses import replace

import numpy as np
import pytest

from workbench import Truth, load_robot, parse_effect, planned, problem_of, random_poses, simulate
from workbench.campaign import drive_torque, torque_columns
from workbench.diagnosis.prepared import prepare
from workbench.effects import catalogue
from workbench.measurement.design.prior_information import from_prepared
from workbench.robot.loads import wrenches

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
        assert not torque_columns.noise(prepared.problem)[j] < 1.8 * found[j]


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


def turned(torque, problem):
    return torque * np.where(np.arange(6) == 2, -1.0, 1.0)


def of_the_motors(torque, problem):
    return torque / 200


def dead(torque, problem):
    return np.where(np.arange(6) == 2, 3.0, torque)


def without_compensator(torque, problem):
    bare = wrenches(problem.arm, problem.rigid, replace(problem.loads, compensator=None))
    return torque + problem.nominal_torque - problem.arm.own(bare.local)


SPOILT = {
    "turned": (turned, {2}),
    "scaled": (of_the_motors, {1, 2, 3, 4}),
    "unrelated": (dead, {2}),
    "without compensator": (without_compensator, {1}),
}


def doubted(campaign):
    return {(one.joint, one.doubt) for one in torque_columns.doubtful(problem_of(campaign))}


@pytest.mark.parametrize("doubt", SPOILT)
def test_torques_that_mean_something_else_are_set_aside(doubt):
    """Of the joints that carry anything beside the flange's axis; the others are used as before."""
    spoil, joints = SPOILT[doubt]
    campaign, _ = measured(HIDDEN["none"])
    sound = prepare(campaign)
    prepared = prepare(campaign.with_poses(torque=spoil(campaign.poses.torque, problem_of(campaign))))
    assert doubted(prepared.problem.campaign) == {(j, doubt) for j in joints}
    others = [j for j in range(6) if j not in joints]
    assert np.isinf(prepared.covariance.torque[[*joints]]).all()
    assert np.allclose(prepared.covariance.torque[others], sound.covariance.torque[others], rtol=0.2)
    (note,) = set(prepared.notes) - set(sound.notes)
    names = [name for name in sound.problem.arm.names if name in note]
    assert names == [sound.problem.arm.names[j] for j in sorted(joints)]


@pytest.mark.parametrize("which", HIDDEN)
def test_a_wrong_load_or_a_motor_constant_is_no_doubt(which):
    campaign, _ = measured(HIDDEN[which])
    scale = np.array([0.9, 1.1, 0.7, 1.4, 1.1, 0.9])
    assert not doubted(campaign)
    assert not doubted(campaign.with_poses(torque=campaign.poses.torque * scale))


def test_friction_that_grows_with_the_load_is_the_drives_own():
    campaign, exact = measured(HIDDEN["none"])
    side = np.random.default_rng(5).choice([-1, 1], exact.shape)
    largest = np.abs(exact).max(axis=0)
    rubbed = campaign.poses.torque + side * (0.05 * largest + 0.1 * np.abs(exact))
    before = drive_torque.scatter(problem_of(campaign))
    after = drive_torque.scatter(problem_of(campaign.with_poses(torque=rubbed, side=side)))
    without = drive_torque.scatter(problem_of(campaign.with_poses(torque=rubbed)))
    assert (after[1:4] < 1.2 * before[1:4]).all()
    assert (without[1:4] > 1.5 * before[1:4]).all()


def test_the_drive_of_a_joint_without_a_stiffness_shows_a_hose():
    def hoses(campaign):
        kind = catalogue()["hose_torque"]
        problem = problem_of(campaign)
        return {effect.where.joint for effect in kind.sites(problem)}, kind.needs(problem)

    plan = planned(load_robot("ur10"), random_poses(load_robot("ur10"), POSES, np.random.default_rng(3)))
    assert hoses(plan)[0] == set()
    assert "drives' torques" in hoses(plan)[1]
    found, lacking = hoses(plan.with_poses(torque=np.zeros_like(plan.poses.q)))
    assert found == {"wrist_1_joint", "wrist_2_joint", "wrist_3_joint"}
    assert lacking is None


def test_what_goes_with_the_joints_own_angle_counts_as_far_as_torques_are_accurate():
    """Of a function of its own angle little is left, of another joint's nearly all."""
    campaign, _ = measured(HIDDEN["none"])
    problem = problem_of(campaign)
    for j, other in ((1, 3), (2, 4), (4, 3)):
        own, foreign = np.zeros((2, POSES, 6, 1))
        own[:, j, 0], foreign[:, j, 0] = np.sin(problem.q[:, j]), np.sin(problem.q[:, other])
        shares = [
            np.square(drive_torque.project(problem, v)).sum() / np.square(v).sum() for v in (own, foreign)
        ]
        assert shares[0] < 0.2
        assert shares[1] > 0.5
