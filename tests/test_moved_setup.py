"""What is smooth in time is no step of the instrument or the tool."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import measured, robot

from workbench import fit, problem_of
from workbench.campaign import join, load_campaign, write_campaign
from workbench.campaign.planned import random_poses
from workbench.diagnosis.data_faults.moved_setup import _of_one_pose
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.weighing.places_of_steps import Taken, gains_of, prefix


def test_an_arm_that_warms_up_has_no_tool_that_was_mounted_anew():
    time = 60.0 * np.arange(90)
    warm = f"thermal_growth:variant=warmup,coefficient=2.5e-4,constant={0.2 * time[-1]:.0f},start=0"
    campaign = measured("iiwa7", (warm,), poses=90, seed=4, loads=(), time=time, sigma=2e-5)
    assert prepare(campaign).faults == ()


def test_a_slide_that_is_not_straight_has_no_instrument_that_moved():
    """Chance orders some of its errors like a step; they are alike in the points of a pose."""

    def crooked(problem):
        travel = 2 * np.pi * problem.q[:, 1] / 0.35
        return {6 * 2 + 3: 1e-3 * np.sin(travel + 1), 6 * 2 + 4: 1e-3 * np.cos(1.7 * travel)}

    assert (
        prepare(measured("cylindrical", poses=60, loads=(), seed=6, sigma=2e-5, motion=crooked)).faults == ()
    )


def test_an_instrument_that_moved_in_one_of_several_campaigns_is_told_by_its_pose(tmp_path):
    """None of its poses are outliers."""
    rng = np.random.default_rng(3)
    paths = []
    for name in ("first", "second"):
        campaign = measured("cylindrical", poses=40, loads=(), q=random_poses(robot("cylindrical"), 40, rng))
        if name == "second":
            campaign.points[25:] += 5e-4
        paths.append(write_campaign(tmp_path / name, campaign))
    campaigns = [load_campaign(path) for path in paths]
    prepared = prepare(campaigns)
    assert prepare(join(campaigns)).faults == prepared.faults
    (fault,) = prepared.faults
    assert (fault.kind, fault.pose_id) == ("moved_instrument", "second/26")
    campaign = prepared.problem.campaign
    assert campaign.setup_names == ("first", "second", "second after pose second/25")
    assert np.bincount(campaign.poses.setup).tolist() == [40, 25, 15]
    assert campaign.seen.all()


@pytest.mark.parametrize("first", [60, 74])
def test_an_instrument_that_moved_in_one_of_two_set_ups_of_a_campaign_is_told(first):
    """In the middle of the second one, or before its last six poses: these are no outliers."""
    campaign = measured("ur5", poses=80, loads=(), seed=9, sigma=2e-5)
    setup = (np.arange(80) >= 40).astype(int)
    campaign = replace(campaign.with_poses(setup=setup), setup_names=("one day", "the next"))
    assert prepare(campaign).faults == ()
    campaign.points[40:] += 0.3
    campaign.points[first:] += (4e-4, -5e-4, 3e-4)
    prepared = prepare(campaign)
    (fault,) = prepared.faults
    assert (fault.kind, fault.pose_id) == ("moved_instrument", campaign.poses.ids[first])
    assert np.bincount(prepared.problem.campaign.poses.setup).tolist() == [40, first - 40, 80 - first]
    assert prepared.problem.campaign.seen.all()


def test_a_tool_that_slips_is_found_among_few_poses_of_one_target():
    """Smooth functions of the joints are as many there as the data, but none so large as to stand in for it;
    nor is a strong error of one joint's own angle such a step."""

    def slip(problem):
        after = np.arange(len(problem.q)) >= 30
        return {6 * (problem.arm.n + 1) + k: far * after for k, far in enumerate((4e-4, -3e-4, 3e-4))}

    slipped = measured("ur5", poses=64, loads=(), targets=1, seed=8, sigma=2e-5, motion=slip)
    (fault,) = prepare(slipped).faults
    assert (fault.kind, fault.pose_id) == ("changed_setup", slipped.poses.ids[30])
    mapped = measured(
        "ur5", ("joint_map:joint=elbow_joint",), poses=64, loads=(), targets=1, seed=8, sigma=2e-5
    )
    assert prepare(mapped).faults == ()


@pytest.mark.parametrize("wild", [False, True])
def test_a_wild_point_is_no_step(wild):
    """The last six poses moved, or one of them alone."""
    campaign = measured("6R", poses=60, loads=(), sigma=2e-5)
    points = campaign.points.copy()
    if wild:
        points[57, 1] += [0.0, 6e-4, 0.0]
    else:
        points[54:] += [0.0, 6e-4, 0.0]
    geometry = prepare(campaign).geometry
    moved = replace(geometry.model, problem=problem_of(replace(campaign, points=points)))
    found = fit(moved, geometry.state, geometry.noise)
    own, taken = np.arange(60), Taken.by(found)
    base = np.matmul(found.whitener, found.line.frame)
    gain = gains_of(*prefix(taken, base, own))[54]
    assert gain > 60
    assert _of_one_pose(taken, base, own, 54, gain) == wild
