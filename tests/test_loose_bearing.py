"""A bearing that is worn tips over as the moment on it changes its side: a form of a bearing's tilt."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench import Truth, diagnose, load_robot, planned, random_poses, simulate
from workbench.campaign.problem import problem_of
from workbench.effects.bearing_tilt import BearingTilt, LooseBearing
from workbench.effects.place import Where
from workbench.effects.records import parse_effect
from workbench.robot.kinematics import RX, RY


def test_the_slope_of_its_law_is_that_of_its_motion():
    loose = LooseBearing(Where(joint="joint_3"), "play 0.1", 40.0)
    rng = np.random.default_rng(1)
    wrench, values, step = 60 * rng.normal(size=(5, 6)), np.array([1e-4]), 1e-5
    arm = problem_of(measured("6R")).arm
    motion, by_wrench, by_value = loose.law(arm, wrench, values)
    assert np.abs(np.linalg.norm(motion, axis=1)).max() <= 1e-4
    assert not np.delete(motion, (RX, RY), axis=1).any()
    assert by_value[..., 0] * 1e-4 == pytest.approx(motion)
    for k in range(6):
        ahead, behind = (loose.law(arm, wrench + s * step * np.eye(6)[k], values)[0] for s in (1, -1))
        assert by_wrench[:, :, k] == pytest.approx((ahead - behind) / (2 * step), abs=1e-12)
    still = loose.law(arm, np.zeros((1, 6)), values)
    assert not still[0].any()
    assert np.isfinite(still[1]).all()


def test_a_joint_that_bears_a_moment_may_have_play():
    problem = problem_of(measured("6R"))
    loose = [one for one in BearingTilt.sites(problem) if one.rare]
    assert {one.variant for one in loose} == {"play 0.02", "play 0.1", "play 0.3"}
    assert {one.key for one in loose} <= {one.key for one in BearingTilt.even(problem)}


@pytest.mark.parametrize("seed", [1, 2])
def test_play_of_a_bearing_is_not_its_neighbours_lost_motion(seed):
    robot, rng = load_robot("iiwa7"), np.random.default_rng(seed)
    q = random_poses(robot, 70, rng)
    plan = planned(robot, q, payloads={"h": (5.0, (0.05, 0.0, 0.1))}, payload=["", "h"] * 35)
    problem = problem_of(plan)
    loose = parse_effect("bearing_tilt:joint=joint_4,variant=play 0.02,amplitude=3e-4,torque=6", problem)
    points = simulate(plan, Truth(effects=(loose,), sigma=3e-5), seed=seed).points
    found = diagnose(replace(plan, points=points, noise_sigma=3e-5)).diagnosis
    assert [c.label for c in found.causes] == ["bearing_tilt(joint_4)"]
    assert found.causes[0].status == "named"
    assert "has play" in found.causes[0].sentence
