"""Poses that a robot could stand in, against where its own kinematics put its flange."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.campaign.planned import planned
from workbench.campaign.problem import problem_of
from workbench.robot.description import load_robot
from workbench.studies.clearance import clear_numbers, clear_poses, clear_table

UP = np.zeros((1, 6))


def test_poses_below_the_floor_and_into_itself_are_told() -> None:
    robot = load_robot("rx170")
    q = np.random.default_rng(0).uniform(-2.0, 2.0, size=(120, 6))
    flange = problem_of(planned(robot, q)).rigid.p[-1][:, 2]
    below, above = q[flange < -0.1], q[flange > 1.2]
    assert min(len(below), len(above)) > 5
    found = clear_poses(robot, {"below": below, "above": above, "upright": UP})
    assert found["below"].above == 0
    assert found["above"].above >= 0.8 * len(above)
    assert (found["upright"].both, found["upright"].poses) == (1, 1)
    n = clear_numbers(found)
    assert n["clear_poses"] == len(below) + len(above) + 1
    assert n["clear_both"] <= min(n["clear_above"], n["clear_itself"])
    assert [row[0] for row in clear_table(found).rows] == ["below", "above", "upright"]


@pytest.mark.parametrize("name", ["kr500", "kr120", "longlink", "cylindrical"])
def test_a_robot_stands_in_its_zero_pose(name: str) -> None:
    robot = load_robot(name)
    (found,) = clear_poses(robot, {"zero": np.zeros((1, len(robot.joints)))}).values()
    assert (found.above, found.itself, found.both) == (1, 1, 1)
