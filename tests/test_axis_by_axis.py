"""Stiffness axis by axis: intervals that hold, the other joints kept apart, what a level cannot see."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench.campaign import Target
from workbench.identification.restated import restated, stored
from workbench.measurement.axis_by_axis import POINTER, LocalStiffness, identify, levels, local_plan
from workbench.robot.description import Robot, load_robot
from workbench.robot.schema import EffectRecord
from workbench.simulation.virtual_campaign import Truth, simulate

FLAT = np.deg2rad([0, 0, 90, 0, 0, 0])
LOADS = np.tile(np.linspace(0, 500, 11), 2)
UPRIGHT = np.eye(3)[None], np.zeros((1, 3))


def softer(robot: Robot, **compliance: float) -> Robot:
    """The robot with compliances so much larger, in parts of the nominal."""
    records = [
        EffectRecord(cause="joint_compliance", joint=name, values={"relative": more})
        for name, more in compliance.items()
    ]
    return replace(robot, effects=tuple(records))


def by_level(joint: str, truth: Robot, sigma: float, seed: int = 0) -> LocalStiffness:
    """A vertical load at the hand, levels on the links of `joint`."""
    robot = load_robot("rx170")
    plan = local_plan(truth, FLAT, (0, 0, -1, 0, 0.5, 0), LOADS, levels(robot, FLAT, joint))
    still = Truth(sigma=sigma * POINTER, repeatability=np.zeros(6))
    seen = simulate(plan, still, seed=seed, instrument=UPRIGHT)
    return identify(replace(seen, robot=robot, noise_sigma=5e-6 * POINTER), joint, levelled=True)


def test_two_levels_take_the_joints_before_out_of_it() -> None:
    # the load turns joints 2 and 3 much more than joint 5; without noise only joint 5's own is left
    truth = softer(load_robot("rx170"), joint_2=0.3, joint_3=-0.2, joint_5=0.25)
    found = by_level("joint_5", truth, 0.0)
    assert found.value == pytest.approx(0.12e6 / 1.25, rel=2e-4)
    assert found.torque == pytest.approx(500 * (0.115 + 0.5), rel=1e-6)
    assert found.turn == pytest.approx(found.torque / found.value, rel=1e-6)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    truth = softer(load_robot("rx170"), joint_3=0.15)
    found = [by_level("joint_3", truth, 5e-6, seed) for seed in range(12)]
    off = np.array([(f.value * 1.15 / 0.57e6 - 1) / f.relative_std for f in found])
    assert 3 < (off**2).sum() < 28  # χ² of 12, its middle 99 %
    assert all(f.low < f.value < f.high for f in found)


def test_a_tracker_sees_joint_2_by_targets_on_both_links() -> None:
    robot = load_robot("rx170")
    places = ((0.3, -0.2, 0.1), (-0.3, 0.15, 0.1), (0.0, -0.35, 0.2))
    targets = [Target(f"{on}{i}", xyz, on) for on in ("link_1", "link_2") for i, xyz in enumerate(places)]
    truth = softer(robot, joint_1=0.4, joint_2=-0.1)
    plan = local_plan(truth, FLAT, (-1, 0, 0, 0, 0, 0), LOADS, targets)
    seen = simulate(plan, Truth(sigma=1e-6, repeatability=np.zeros(6)))
    found = identify(replace(seen, robot=robot), "joint_2")
    assert found.value == pytest.approx(0.85e6 / 0.9, rel=4 * found.relative_std)
    assert found.relative_std < 5e-3


def test_a_level_does_not_see_a_turn_about_the_vertical() -> None:
    with pytest.raises(ValueError, match="joint_1 stands upright"):
        levels(load_robot("rx170"), FLAT, "joint_1")


def test_a_restated_robot_comes_back_from_its_file(tmp_path: Path) -> None:
    robot = load_robot("rx170")
    other = restated(restated(robot, ["joint_2"], stiffness=1e6), gear_ratio=None)
    assert [j.data.stiffness for j in other.joints][:3] == [0.204e6, 1e6, 0.57e6]
    effect = EffectRecord(
        cause="gear_kinematic_error", joint="joint_2", order=200.0, values={"amplitude": 1e-5}
    )
    again = stored(tmp_path / "model.toml", other, [effect])
    assert all(joint.data.gear_ratio is None for joint in again.joints)
    assert again.joints[1].data.stiffness == 1e6
    assert again.effects == (effect,)
    assert robot.joints[1].data.gear_ratio == 140.0
