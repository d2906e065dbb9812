"""Shots of one standstill that are written as rows of their own."""

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench import diagnose
from workbench.campaign import Campaign
from workbench.campaign.problem import problem_of
from workbench.diagnosis.data_faults import standstills
from workbench.diagnosis.prepared import prepare

UNSEEN = 3e-5  # rad, by which each joint misses its command, anew each time that it comes


def taken_together(campaign: Campaign):
    """Campaign, faults and remarks of `standstills.taken_together`."""
    problem, faults, told = standstills.taken_together(problem_of(campaign))
    return problem.campaign, faults, told


def standing(poses=40, shots=3, seed=5, **columns) -> Campaign:
    """Each pose `shots` times on end, off by the same each time, and the instrument nearly without noise."""
    rng = np.random.default_rng(seed)
    off = rng.normal(size=(poses, 6)) * UNSEEN
    once = measured("irb120", poses=poses, loads=(), seed=seed, sigma=1e-6, joints=lambda job: off, **columns)
    rows = np.repeat(np.arange(poses), shots)
    many = once.some(rows)
    many = many.with_poses(ids=tuple(f"row_{i}" for i in range(len(rows))))
    return Campaign(**{**vars(many), "points": many.points + rng.normal(size=many.points.shape) * 1e-6})


def test_rows_on_end_are_shots_of_one_pose():
    campaign = standing()
    together, faults, told = taken_together(campaign)
    assert len(together.poses) == 40
    assert not faults
    assert "80 rows have the joints of the row before" in told[0]
    assert together.poses.ids[1] == "row_3"
    np.testing.assert_allclose(together.points[1], campaign.points[3:6].mean(axis=0), atol=1e-12)
    assert (together.shots == 3).all()
    square, dof = together.shot_scatter
    assert dof == 40 * 3 * 3 * 2
    assert np.sqrt(square / dof) == pytest.approx(1e-6, rel=0.1)


def test_poses_that_are_come_back_to_stay_poses():
    campaign = standing()
    back = campaign.some(np.argsort(np.arange(len(campaign.poses)) % 3, kind="stable"))
    together, _, told = taken_together(back)
    assert together is back
    assert not told
    some = np.append(np.arange(10), np.random.default_rng(0).permutation(np.tile(np.arange(10, 40), 3)))
    shuffled = campaign.some(3 * some)
    assert (np.diff(some) == 0).any()
    assert taken_together(shuffled)[0] is shuffled


def test_a_standstill_of_hours_is_no_standstill():
    campaign = standing(poses=10, shots=4)
    hours = campaign.with_poses(time=np.arange(40) * 1800.0)
    assert len(taken_together(hours)[0].poses) == 40
    assert len(taken_together(campaign.with_poses(time=np.arange(40) * 5.0))[0].poses) == 10


def test_a_wild_shot_is_told_and_left_out():
    campaign = standing()
    points = campaign.points.copy()
    points[4, 1] += [0.0, 0.002, 0.0]
    together, faults, _ = taken_together(Campaign(**{**vars(campaign), "points": points}))
    assert [(fault.kind, fault.pose_id) for fault in faults] == [("outlier", "row_4")]
    np.testing.assert_allclose(together.points[1, 1], campaign.points[[3, 5], 1].mean(axis=0), atol=1e-12)
    assert together.shots[1].tolist() == [3, 2, 3]


def test_a_shot_of_nothing_is_no_part_of_the_mean():
    campaign = standing(shots=2)
    points = campaign.points.copy()
    points[2] = 0.0
    ready = prepare(Campaign(**{**vars(campaign), "points": points}))
    at = ready.problem.campaign.poses.ids.index("row_2")
    np.testing.assert_allclose(ready.problem.campaign.points[at], campaign.points[3], atol=1e-12)
    assert {fault.pose_id for fault in ready.faults} == {"row_2"}


def test_what_is_off_alike_in_all_shots_is_no_cause():
    """What a joint misses by at a standstill is no function of its angle, however often it is seen there."""
    found = diagnose(standing(poses=60, state_sigma=False)).diagnosis
    assert not [cause.label for cause in found.causes if cause.status == "named"]
    assert found.stages[-1].heldout_rms_mm < 1.05 * found.stages[1].heldout_rms_mm
