"""A swept joint: its error without what the instrument's frame may take, its lines, their shaft; heights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from workbench.campaign import Campaign, Target
from workbench.campaign.problem import Problem
from workbench.correction.path_shapes import Run, circle, work_frame
from workbench.identification.restated import restated
from workbench.measurement.sweep import GearLine, gear_lines, gear_of, joint_error, shaft, sweep
from workbench.robot.description import load_robot
from workbench.robot.kinematics import Array
from workbench.robot.schema import EffectRecord
from workbench.simulation.virtual_campaign import Truth, simulate
from workbench.studies.rx170.causes import one_cause_each, standing_error
from workbench.studies.rx170.heights import heights, least_mean

ENDS = (-0.9, 0.9)


def gear(q: Array) -> Array:
    """An error that is no sum of sines: a fundamental that grows, and a bend."""
    return (6e-5 + 2e-5 * q) * np.sin(123.4 * q + 0.5) + 3e-5 * q**2


@pytest.fixture(scope="module")
def swept() -> Campaign:
    """Joint 2 with this error and its nominal yield, 400 poses, ratio unknown."""
    robot = restated(load_robot("rx170"), gear_ratio=None)
    target = Target("T", (0.0, -0.25, 0.95), "link_2")
    plan = sweep(robot, "joint_2", np.zeros(6), ENDS, 400, target)

    def joints(job: Problem) -> Array:
        return np.where(np.arange(6) == 1, gear(job.q[:, 1])[:, None], 0.0)

    return simulate(plan, Truth(joints=joints, sigma=1e-6, repeatability=np.zeros(6)), seed=1)


def test_joint_error_is_the_gears_where_the_robot_yields_as_it_should(swept: Campaign) -> None:
    expected = gear(swept.poses.q[:, 1])
    found = joint_error(swept, "joint_2")
    assert np.abs(found - (expected - expected.mean())).max() < 6e-6  # 4 σ of 1 µm at 0.95 m, and the circle
    assert found.mean() == pytest.approx(0.0, abs=1e-12)


def test_joint_error_of_a_rigid_robot_holds_the_yield_too(swept: Campaign) -> None:
    rigid = replace(swept, robot=restated(swept.robot, stiffness=None))
    yielded = joint_error(rigid, "joint_2") - joint_error(swept, "joint_2")
    assert 3e-4 < np.ptp(yielded) < 5e-4  # some 340 N·m over 0.85e6 N·m/rad
    assert np.abs(np.diff(yielded)).max() < 1e-5  # smooth: all of the lines is in the gear


def test_the_line_is_found_without_a_ratio_and_its_interval_holds(swept: Campaign) -> None:
    first = gear_lines(gear_of(swept, "joint_2"))[0]
    assert first.low < 123.4 < first.high
    assert first.high - first.low < 0.5  # far below the 3.5 orders that the sweep resolves
    assert first.amplitude == pytest.approx(6e-5, rel=0.05)


def test_the_shaft_counts_whole_cycles_and_leaves_the_motor_out() -> None:
    orders = (200.02, 399.8, 100.1, 140.2)
    lines = [GearLine(order, order - 0.2, order + 0.2, 1e-5, 1e-6) for order in orders]
    turns, cycles = shaft(lines)
    assert turns == pytest.approx(100.01)
    assert cycles == [2, 4, 1, 0]


def test_single_causes_add_up_to_the_whole_error() -> None:
    robot = load_robot("rx170")
    records = [
        EffectRecord(cause="joint_compliance", joint="joint_3", values={"relative": 0.2}),
        EffectRecord(cause="gear_kinematic_error", joint="joint_2", order=200.0, values={"amplitude": 6e-5}),
        EffectRecord(cause="gear_kinematic_error", joint="joint_3", order=200.0, values={"amplitude": 4e-5}),
    ]
    truth = replace(robot, effects=tuple(records))
    path = circle(0.05, Run(work_frame([1.0, 0.0, 0.95]), period=0.1))
    start = np.array([0.0, 0.4, 1.8, 0.0, 0.95, 0.0])
    parts = {key: standing_error(one, path, start) for key, one in one_cause_each(truth, "joint_2").items()}
    assert list(parts) == ["yield_joint_2", "gear_joint_2", "yield_others", "gear_others"]
    np.testing.assert_allclose(sum(parts.values()), standing_error(truth, path, start), atol=2e-6)
    assert min(np.ptp(part[:, 2]) for part in parts.values()) > 1e-5


def test_heights_of_a_tilted_plane_with_a_step() -> None:
    x = np.linspace(0, 1, 100)
    wanted = np.column_stack([x, np.sin(20 * x), np.zeros(100)])
    error = np.column_stack([0 * x, 0 * x, 2e-4 + 1e-4 * x])
    found = heights(wanted, error, 2e-4, np.zeros(100))
    assert found["ra_base"] == pytest.approx(0.25, abs=1e-3)
    assert found["ra"] == pytest.approx(0.05, abs=1e-3)
    assert found["rz"] == pytest.approx(0.1)
    assert found["rz_level"] == pytest.approx(0.0, abs=1e-9)
    assert found["rz_seen"] == found["rz"]


def test_least_mean_is_that_of_linear_programming() -> None:
    for ra, rz in ((0.2032, 0.2882), (0.15, 0.2), (0.07, 0.1)):
        least = float(np.inf)
        for low in np.linspace(
            0, rz / 2, 60
        ):  # every profile from −low to rz − low, by the share of each height
            z = np.linspace(-low, rz - low, 80)
            best = linprog(z, A_eq=[np.ones(80), np.abs(z)], b_eq=[1, ra])
            least = min(least, float(best.fun or 0.0) if best.success else np.inf)
        assert least_mean(ra, rz) == pytest.approx(least, abs=2e-3)
    assert least_mean(0.05, 0.2) < 0.02  # a span four times as wide says little
