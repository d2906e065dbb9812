"""Joints that are written down with too few digits while they stand still for many poses."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.campaign.planned import planned, random_poses
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.run import diagnose
from workbench.robot.description import load_robot
from workbench.simulation.virtual_campaign import Truth, simulate

HELD = [2, 3, 4, 5]


def held_in_runs(written: bool, seed=4, rows=16, first_target=0.0, poses=320, elbow=0.0):
    """Poses of a robot without a fault, in runs of so many rows in which four joints stand still. All
    joints are written to 0.1°, or else are exactly there. first_target: [m] off its place on the tool.
    elbow: [rad] what its gear errs by, twice per turn."""
    robot, rng = load_robot("ur5"), np.random.default_rng(seed)
    q = random_poses(robot, poses, rng)
    q[:, HELD] = np.repeat(q[::rows][:, HELD], rows, axis=0)
    to_digits = np.radians(np.round(np.degrees(q), 1))
    real = (q if written else to_digits) + elbow * np.sin(2 * q) * (np.arange(q.shape[1]) == HELD[0])
    plan = planned(robot, real)
    x, y, z = plan.targets[0].xyz
    plan = replace(plan, targets=(replace(plan.targets[0], xyz=(x + first_target, y, z)), *plan.targets[1:]))
    seen = simulate(plan, Truth(sigma=2e-5), seed=seed)
    return replace(seen.with_poses(q=to_digits), noise_sigma=None)


def test_rounding_is_no_fault_of_a_gear():
    outcome = diagnose(held_in_runs(written=True, poses=208))
    found, names = outcome.diagnosis, [outcome.problem.arm.names[j] for j in HELD]
    assert not [finding for finding in found.causes if finding.status == "named"]
    assert {fault.kind for fault in found.faults} == {"rounded_joints"}
    untested = {(item.cause, item.where.joint) for item in found.not_testable}
    assert untested >= {("joint_map", name) for name in names}
    assert untested >= {("gear_kinematic_error", name) for name in names}
    assert untested >= {("gear_ratio", name) for name in names}


def test_round_commands_are_believed():
    outcome = diagnose(held_in_runs(written=False, poses=208))
    assert outcome.problem.rounded == ()
    assert outcome.diagnosis.verdict == "nothing_missing"
    assert not outcome.diagnosis.faults
    assert ("joint_map", "elbow_joint") not in {
        (item.cause, item.where.joint) for item in outcome.diagnosis.not_testable
    }


def test_a_joint_that_errs_by_more_than_its_rounding_is_not_suspected_of_it():
    held = [load_robot("ur5").joints[j].name for j in HELD]
    assert prepare(held_in_runs(written=True, poses=208)).problem.rounded == tuple(held)
    for written in (True, False):
        campaign = held_in_runs(written, poses=208, elbow=3e-3)
        assert held[0] not in prepare(campaign).problem.rounded


def faults_before_causes(campaign):
    """The data faults that are found before any cause is sought; there rounding is suspected already."""
    ready = prepare(campaign)
    assert ready.problem.rounded
    return ready.faults


@pytest.mark.parametrize(
    ("seed", "rows"),
    [
        pytest.param(3, 8, marks=pytest.mark.slow),
        pytest.param(5, 8, marks=pytest.mark.slow),
        (2, 16),
    ],
)
def test_what_rounding_does_in_runs_is_no_tool_that_moved(seed, rows):
    assert not faults_before_causes(held_in_runs(written=True, seed=seed, rows=rows))


def test_a_target_that_moved_by_more_than_rounding_is_still_found():
    campaign, elsewhere = (held_in_runs(True, seed=2, rows=8, first_target=off) for off in (0.0, 2e-3))
    points = campaign.points.copy()
    points[170:, 0] = elsewhere.points[170:, 0]
    (moved,) = faults_before_causes(replace(campaign, points=points))
    assert (moved.kind, moved.target) == ("changed_setup", campaign.targets[0].name)
    assert abs(int(moved.pose_id) - 170) <= 8


def test_an_instrument_that_moved_by_more_than_rounding_is_still_found():
    campaign = held_in_runs(written=True, seed=2)
    points = campaign.points.copy()
    points[170:] += [2e-3, -1e-3, 0.0]
    (moved,) = faults_before_causes(replace(campaign, points=points))
    assert moved.kind == "moved_instrument"
