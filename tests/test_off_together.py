"""Poses that are off in the way of one cause are no outliers, few as they are; those off by chance are."""

from dataclasses import replace

import numpy as np
import pytest

from workbench import Truth, diagnose, load_robot, planned, random_poses, simulate
from workbench.diagnosis.prepared import prepare


def few_from_the_other_side(seed, wild=0):
    """Of 50 poses 8 from the other side, with play in a form that the library has not.
    And as many wild points as asked for."""
    robot, rng = load_robot("kr500"), np.random.default_rng(seed)
    side = np.ones((50, 6))
    side[rng.choice(50, 8, replace=False), 1] = -1

    def play(problem):
        out = np.zeros(problem.q.shape)
        out[:, 1] = 3e-4 * side[:, 1] * (1 + 0.2 * np.tanh(problem.q[:, 1]))
        return out

    plan = planned(robot, random_poses(robot, 50, rng), direction=side)
    campaign = simulate(plan, Truth(joints=play, sigma=3e-5), seed=seed)
    points, which = campaign.points.copy(), rng.choice(50, wild, replace=False)
    points[which] += rng.normal(0, 0.02, (wild, 1, 3))
    return replace(campaign, points=points), {campaign.poses.ids[i] for i in which}


@pytest.mark.parametrize(("seed", "wild"), [(1, 0), (2, 3)])
def test_a_few_poses_from_the_other_side_tell_the_play(seed, wild):
    campaign, off = few_from_the_other_side(seed, wild)
    found = diagnose(campaign).diagnosis
    assert {fault.pose_id for fault in found.faults} == off
    first = found.causes[0]  # its form is foreign: the approach of joint_2, play or something without a name
    assert first.where.joint == "joint_2"
    assert "backlash" in {first.cause, *(rival.cause for rival in first.rivals)}
    assert first.gain_mm > 0.3


def test_what_is_off_by_chance_or_for_a_while_is_left_out():
    """One after the other, or in a block that an instrument was pushed in."""
    robot, rng = load_robot("kr500"), np.random.default_rng(5)
    plan = planned(robot, random_poses(robot, 60, rng), direction=rng.choice([-1.0, 1.0], (60, 6)))
    sound = simulate(plan, Truth(sigma=3e-5), seed=5)
    chance, block = rng.choice(60, 6, replace=False), np.arange(20, 26)
    for which, shift in ((chance, rng.normal(0, 2e-3, (6, 1, 3))), (block, np.full((6, 1, 3), 1.5e-3))):
        points = sound.points.copy()
        points[which] += shift
        faults = prepare(replace(sound, points=points)).faults
        assert {fault.pose_id for fault in faults} == {sound.poses.ids[i] for i in which}


def test_a_wild_point_at_the_end_of_a_joint_s_range_is_no_neighbour_of_itself():
    robot, rng = load_robot("irb120"), np.random.default_rng(6)
    sound = simulate(planned(robot, random_poses(robot, 80, rng)), Truth(sigma=3e-5), seed=6)
    q = sound.poses.q
    for ends in ([q[:, 0].argmin()], [q[:, 3].argmax()], np.unique([q.argmin(axis=0), q.argmax(axis=0)])):
        points = sound.points.copy()
        points[ends, 1] += [0.0, 2e-3, 0.0]
        faults = prepare(replace(sound, points=points)).faults
        assert {(fault.pose_id, fault.target) for fault in faults} == {
            (sound.poses.ids[n], "T2") for n in ends
        }


def test_what_the_other_poses_foretell_is_no_outlier():
    """Three poses of 60 under a load, in an arm that bends by its own weight; and one point that is off."""
    robot, rng = load_robot("irb120"), np.random.default_rng(3)
    heavy = np.isin(np.arange(60), [11, 30, 47])
    plan = planned(
        robot,
        random_poses(robot, 60, rng),
        payloads={"heavy": (3.0, (0.0, 0.0, 0.1))},
        payload=["heavy" if one else "" for one in heavy],
    )

    def soft(problem):
        load = problem.nominal_load.local[:, 3, 5]
        out = np.zeros(problem.q.shape)
        out[:, 2] = 8e-5 * load * (1 + 0.1 * np.abs(load) / np.abs(load).max())
        return out

    campaign = simulate(plan, Truth(joints=soft, sigma=3e-5), seed=4)
    assert not prepare(campaign).faults
    points = campaign.points.copy()
    points[20, 1] += [0.0, 2e-3, 0.0]
    faults = prepare(replace(campaign, points=points)).faults
    assert [(fault.kind, fault.pose_id) for fault in faults] == [("outlier", campaign.poses.ids[20])]
