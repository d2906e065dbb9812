"""A cause of a size that it has on no machine is something else."""

import numpy as np
import pytest

from workbench import Truth, diagnose, load_robot, parse_effect, planned, problem, random_poses, simulate
from workbench.effects.base import UNKNOWN


def _warming(growth, poses=120, seed=4):
    """A diagnosis of an arm that grows by so much per metre while it warms up."""
    robot = load_robot("irb120")
    times = 30.0 * np.arange(poses)
    plan = planned(robot, random_poses(robot, poses, np.random.default_rng(seed)), time=times)
    hidden = f"thermal_growth:variant=warmup 0.4,coefficient={growth}"
    grown = parse_effect(hidden, problem(plan))
    return diagnose(simulate(plan, Truth(effects=(grown,), sigma=2e-5), seed=seed)).diagnosis


def test_an_arm_that_warms_up_is_named():
    (cause,) = _warming(4e-4).causes
    assert cause.cause == "thermal_growth"


@pytest.mark.slow
@pytest.mark.parametrize("growth", [8e-3, -8e-3])
def test_no_arm_grows_by_millimetres_per_metre(growth):
    found = _warming(growth)
    assert found.verdict == "unknown"
    (cause,) = found.causes
    assert cause.cause == UNKNOWN
    assert "looks like thermal growth, but of a size that it has on no machine" in cause.structure


@pytest.mark.parametrize(("share", "poses"), [pytest.param(0.1, 60, marks=pytest.mark.slow), (1.5, 40)])
def test_no_link_weighs_more_than_the_whole_arm(share, poses):
    """A share of the arm's mass that is added to link_2: more than one is what something else does."""
    robot = load_robot("kr120")
    plan = planned(robot, random_poses(robot, poses, np.random.default_rng(1)))
    whole = float(problem(plan).arm.mass.sum())
    heavier = parse_effect(f"link_mass:link=link_2,mass={share * whole}", problem(plan))
    found = diagnose(simulate(plan, Truth(effects=(heavier,), sigma=2e-5), seed=1)).diagnosis
    said = {one.cause for cause in found.causes for one in (cause, *cause.rivals)}
    assert ("link_mass" in said) is (share < 1)  # a tie: a run-out of joint 2 is as likely
