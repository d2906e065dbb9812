"""Joints that are written down with too few digits while they stand still for many poses."""

from dataclasses import replace

import numpy as np

from workbench.campaign.planned import planned, random_poses
from workbench.diagnosis.run import diagnose
from workbench.robot.description import load_robot
from workbench.simulation.virtual_campaign import Truth, simulate

HELD = [2, 3, 4, 5]


def held_in_runs(written: bool, seed=4):
    """20 runs of 16 poses of a robot without a fault, in each of which four joints stand still. All joints
    are written to 0.1°, or else are exactly there."""
    robot, rng = load_robot("ur5"), np.random.default_rng(seed)
    q = random_poses(robot, 320, rng)
    q[:, HELD] = np.repeat(q[::16][:, HELD], 16, axis=0)
    to_digits = np.radians(np.round(np.degrees(q), 1))
    plan = planned(robot, q if written else to_digits)
    seen = simulate(plan, Truth(sigma=2e-5), seed=seed)
    return replace(seen.with_poses(q=to_digits), noise_sigma=None)


def test_rounding_is_no_fault_of_a_gear():
    outcome = diagnose(held_in_runs(written=True))
    found, names = outcome.diagnosis, [outcome.problem.arm.names[j] for j in HELD]
    assert not [finding for finding in found.causes if finding.status == "named"]
    assert "rounded_joints" in [fault.kind for fault in found.faults]
    untested = {(item.cause, item.where.joint) for item in found.not_testable}
    assert untested >= {("joint_map", name) for name in names}
    assert untested >= {("gear_kinematic_error", name) for name in names}


def test_round_commands_are_believed():
    outcome = diagnose(held_in_runs(written=False))
    assert outcome.problem.rounded == ()
    assert outcome.diagnosis.verdict == "nothing_missing"
    assert not outcome.diagnosis.faults
    assert ("joint_map", "elbow_joint") not in {
        (item.cause, item.where.joint) for item in outcome.diagnosis.not_testable
    }
