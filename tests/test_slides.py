"""A sliding joint's error along its travel: what a screw or a rack does, in metres."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import found, measured, named

from workbench import load_robot
from workbench.campaign.planned import planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.effects.joint_map import JointMap


def case_of(poses=20):
    robot = load_robot("cylindrical")
    return problem_of(planned(robot, random_poses(robot, poses, np.random.default_rng(2))))


def pitch(q):
    """(N,) [m] error of a screw whose pitch swings, with a bump: no wave of a map."""
    return 8e-5 * np.tanh(3 * np.sin(2 * np.pi * q / 0.31 + 0.3)) + 6e-5 * np.exp(-(((q - 0.2) / 0.06) ** 2))


def hidden(problem):
    return np.eye(3)[2] * pitch(problem.q[:, 2])[:, None]


def test_sliding_joints_have_maps_in_metres():
    case = case_of()
    every = JointMap.sites(case)
    slides = [one for one in every if isinstance(one, JointMap) and one.where.joint == "joint_2"]
    assert {one.variant for one in slides} == {"waves", "fine"}
    for one in slides:
        travelled = np.ptp(case.q[:, 1])
        assert travelled < one.span < 1.3 * travelled
        assert 2 * one.length < travelled
        assert all(p.unit == "m" for p in one.params)
        drawn = one.motion(case)[int(case.arm.axial[1])] @ np.array([p.typical for p in one.params])
        assert 3e-6 < np.sqrt((drawn**2).mean()) < 2e-4
        (told,) = one.report(*example(one))
        assert told.unit == "m"
        assert "µm RMS" in one.sentence(example(one)[0])
        assert "mm)" in one.sentence(example(one)[0])
    turning = next(one for one in JointMap.sites(case) if one.where.joint == "joint_1")
    assert {p.unit for p in turning.params} == {"rad"}
    assert "µrad RMS" in turning.sentence(example(turning)[0])


def example(effect):
    sizes = np.array([p.typical for p in effect.params])
    return sizes, np.diag(sizes**2)


def test_a_map_of_a_joint_that_slides_lies_over_its_travel():
    robot = load_robot("cylindrical")
    for one in JointMap.places(case_of()):
        low, high = one.first, one.first + one.span
        joint = robot.joints[robot.joint_names.index(one.where.joint)]
        slides = joint.kind == "prismatic"
        assert (low, high) == pytest.approx((joint.lower, joint.upper) if slides else (-np.pi, np.pi))


def test_the_pitch_error_of_a_screw_is_named():
    told = found(measured("cylindrical", joints=hidden, poses=90, loads=(20.0,)))
    assert named(told) == {("joint_map", "joint_3"): "named"}
    (cause,) = told.causes
    (size,) = cause.parameters
    assert size.unit == "m"
    assert size.value == pytest.approx(8e-5, rel=0.4)
    assert "travel" in cause.title
    assert "travel" in cause.sentence
    assert told.stages[-1].heldout_rms_mm < 0.75 * told.stages[1].heldout_rms_mm


def test_a_lift_does_not_reach_farther():
    """A hall's lift of 9.5 m under an arm of one metre: poses off its axis and above the floor are found."""
    robot = load_robot("cylindrical")
    lift = replace(robot.joints[1], upper=9.5)
    q = random_poses(
        replace(robot, joints=(robot.joints[0], lift, robot.joints[2])), 20, np.random.default_rng(3)
    )
    assert len(q) == 20
    assert np.ptp(q[:, 1]) > 5
