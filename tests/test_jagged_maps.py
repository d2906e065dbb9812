"""A gear errs in large waves and in ever smaller ones: a map of it, and no row of gear lines beside that."""

import numpy as np
import pytest
from diagnosis_cases import measured, named

from workbench.campaign.problem import problem_of
from workbench.diagnosis.run import diagnose
from workbench.effects.joint_map import JointMap
from workbench.effects.records import from_record, record

ELBOW = 2
KNOTS = np.linspace(-2.4, 2.4, 120)  # rad: every 40 mrad


def postures(count: int, seed: int) -> np.ndarray:
    """Joints (count, 6) of a UR10 whose elbow turns by 150 degrees."""
    lower = np.radians([-170, -150, -20, -170, -170, -170])
    upper = np.radians([170, -30, 130, 170, 170, 170])
    return lower + (upper - lower) * np.random.default_rng(seed).random((count, 6))


def wanders(seed):
    """Straight lines between steps by chance, 0.35 mrad in the end: no waves."""
    steps = np.random.default_rng(seed).choice([-1.0, 1.0], len(KNOTS))
    walk = np.cumsum(steps) * 6e-5

    def error(problem):
        out = np.zeros(problem.q.shape)
        out[:, ELBOW] = np.interp(problem.q[:, ELBOW], KNOTS, walk)
        return out

    return error


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow), 3])
def test_an_error_with_waves_of_all_lengths_is_one_map(seed):
    campaign = measured("ur10", loads=(), q=postures(660, seed), joints=wanders(seed), targets=1, seed=seed)
    told = diagnose(campaign).diagnosis
    assert named(told) == {("joint_map", "elbow_joint"): "named"}
    assert told.causes[0].variant == "jagged"


def jagged(poses: int) -> list[JointMap]:
    """Jagged maps that such a campaign may show."""
    problem = problem_of(measured("ur10", loads=(), q=postures(poses, seed=4)))
    return [one for one in JointMap.sites(problem) if one.variant.startswith("jagged")]


def test_a_jagged_map_needs_a_dozen_poses_for_each_of_its_waves():
    assert not jagged(poses=300)
    found = jagged(poses=660)
    assert {one.where.joint for one in found} >= {"shoulder_lift_joint", "elbow_joint"}
    assert all(12 * len(one.sizes) < 660 for one in found)


def test_a_model_keeps_a_jagged_map_and_its_waves_of_all_lengths():
    problem = problem_of(measured("ur10", loads=(), q=postures(660, seed=4)))
    one = jagged(poses=660)[0]
    values = np.random.default_rng(0).normal(size=len(one.params)) * one.sizes
    kept, numbers = from_record(record(one, values), problem)
    assert kept == one
    assert np.allclose(numbers, values)
    order = np.arange(1, 1 + len(one.sizes)) * np.pi / one.span  # rad⁻¹
    assert order.max() == pytest.approx(50.0, rel=0.05)  # waves down to 7 degrees
    short = order > 10
    assert np.allclose((one.sizes * order)[short] / (one.sizes * order)[-1], 1.0, atol=0.02)
