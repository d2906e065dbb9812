"""Faults far beyond usual sizes, in forms that the library does not have."""

import numpy as np

from workbench.campaign.planned import planned, random_poses
from workbench.diagnosis.run import diagnose
from workbench.robot.description import load_robot
from workbench.simulation.virtual_campaign import Truth, simulate

NOISE = 2e-5  # m


def diagnosed(robot_name, joint, width, heights, seed, poses):
    """Of a robot of which one joint goes farther than it is told by a sum of Gaussian bumps of some heights
    [rad], a width [rad] apart."""
    robot = load_robot(robot_name)
    q = random_poses(robot, poses, np.random.default_rng(seed))
    middles = width * (np.arange(len(heights)) - (len(heights) - 1) / 2)
    off = np.exp(-0.5 * ((q[:, joint, None] - middles) / width) ** 2) @ heights
    seen = simulate(
        planned(robot, q + np.outer(off, np.eye(len(robot.joints))[joint])), Truth(sigma=NOISE), seed=seed
    )
    return diagnose(seen.with_poses(q=q)).diagnosis


def test_a_rough_map_of_milliradians_is_no_wrong_ratio_with_something_left():
    heights = 2.5e-3 * np.random.default_rng(6).normal(size=7)
    found = diagnosed("kr500", 2, 0.48, heights, seed=6, poses=50)
    (cause,) = found.causes
    assert (cause.cause, cause.where.joint, cause.status) == ("joint_map", "joint_3", "named")
    assert found.stages[-1].heldout_rms_mm < 0.06


def test_what_a_run_out_has_beside_its_form_is_in_the_model_and_not_without_a_name():
    heights = 2.5e-3 * np.random.default_rng(1).choice([-1.5, -0.5, 0.5, 1.5], 9)
    found = diagnosed("ur5", 1, 0.5, heights, seed=1, poses=48)
    assert "unknown" not in {cause.cause for cause in found.causes}
    assert found.stages[-1].heldout_rms_mm < 0.08 < 0.1 * found.stages[1].heldout_rms_mm


def test_a_play_that_is_not_the_same_all_around_is_a_play():
    robot, rng = load_robot("ur5"), np.random.default_rng(4)
    q = random_poses(robot, 60, rng)
    side = rng.choice([-1.0, 1.0], q.shape)
    behind = -3e-4 * side[:, 1] * (1 + 0.25 * np.sin(q[:, 1] + 1))
    seen = simulate(planned(robot, q + np.outer(behind, np.arange(6) == 1)), Truth(sigma=NOISE), seed=4)
    (cause,) = diagnose(seen.with_poses(q=q, side=side)).diagnosis.causes
    assert (cause.cause, cause.where.joint, cause.status) == ("backlash", robot.joint_names[1], "named")
    width = cause.parameters[0]
    assert abs(width.value - 3e-4) < 3 * width.std < 0.15 * 3e-4
