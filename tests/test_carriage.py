"""What slides on a carriage tilts where that stands, about all three axes; a ram where its bearings stay."""

import numpy as np
from diagnosis_cases import found, measured, named

from workbench import Truth, load_robot, planned, random_poses, simulate
from workbench.campaign import Target
from workbench.campaign.problem import problem
from workbench.effects.bearing_tilt import BearingTilt
from workbench.robot.kinematics import RX

TARGETS = tuple(Target(f"T{i}", tuple(place)) for i, place in enumerate(np.eye(3) * 0.15 + 0.03))


def plan_of(poses):
    robot = load_robot("cylindrical")
    loads = {"side": (60.0, (0.1, 0.15, -0.1)), "low": (30.0, (0.0, -0.1, -0.2))}
    return planned(
        robot,
        random_poses(robot, poses, np.random.default_rng(6)),
        targets=TARGETS,
        payloads=loads,
        payload=["", "side", "low"] * (poses // 3),
    )


def test_sliding_joints_have_both_forms():
    sites = BearingTilt.even(problem(plan_of(3)))
    forms = {(str(one.where), one.variant) for one in sites}
    assert forms - {(f"joint_{j}", "") for j in (1, 2, 3)} == {(f"joint_{j}", "carriage") for j in (2, 3)}
    assert len(sites) == 5


def test_a_carriage_turns_about_itself_under_the_moment_there():
    arm = problem(plan_of(3)).arm
    carriage = BearingTilt.even(problem(plan_of(3)))[-1]
    wrench, span = np.random.default_rng(1).normal(size=(4, 6)), arm.span[carriage.slot(arm)]
    moved, _, _ = carriage.law(arm, wrench, np.array([2e-6]))
    shift, turn = moved[:, :RX], moved[:, RX:]
    assert np.linalg.norm(span) > 0.1
    assert np.abs(shift - np.cross(turn, span)).max() < 1e-18
    assert np.abs(turn - 2e-6 * (wrench[:, RX:] + np.cross(span, wrench[:, :RX]))).max() < 1e-18


def test_a_carriage_that_tilts_is_named():
    """Joint 3 begins at the carriage of joint 2, wherever that stands, and its load turns it about its own
    axis too; next to it comes a ram that bends where it stands out."""

    def tilts(wrench):
        return np.concatenate([np.zeros(3), 4e-6 * wrench[RX:]])

    data = simulate(plan_of(48), Truth(yields={3: tilts}, sigma=2e-5), seed=6)
    assert named(found(data)) == {("bearing_tilt", "joint_2"): "named"}


def test_a_guide_may_give_by_milliradians():
    """77.7 N·m tilt it by 2.4 mrad, as the column of a lift: no link is likelier to bend by that."""
    tilt = ("bearing_tilt:joint=joint_2,compliance=3.09e-5",)
    plan = measured("cylindrical", tilt, seed=2, loads=(), targets=1, state_sigma=False, sigma=1e-4)
    (first,) = found(plan).causes
    assert (first.cause, str(first.where)) == ("bearing_tilt", "joint_2")
