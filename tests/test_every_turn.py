"""A joint that turns more than once errs the same in every turn, where its output makes the error."""

import numpy as np
import pytest
from diagnosis_cases import SIGMA, measured, named

from workbench.campaign.problem import problem_of
from workbench.diagnosis.run import diagnose
from workbench.effects.joint_map import JointMap
from workbench.effects.records import from_record, record

WRIST = 3  # wrist_1_joint


def postures(low: float, high: float, count: int, seed: int) -> np.ndarray:
    """Joints (count, 6) of a UR10 whose first wrist goes from `low` to `high` degrees."""
    rng = np.random.default_rng(seed)
    lower = np.radians([-170, -150, -140, low, -170, -170])
    upper = np.radians([170, -30, 140, high, 170, 170])
    return lower + (upper - lower) * rng.random((count, 6))


def bumps(problem):
    """Bent waves that come again after a turn: no sum of a few sines."""
    q, out = problem.q[:, WRIST], np.zeros(problem.q.shape)
    out[:, WRIST] = 2.5e-4 * (np.arcsin(0.95 * np.sin(5 * q)) + np.tanh(2 * np.sin(9 * q + 1)) * np.cos(q))
    return out


def elsewhere(problem):
    """The same that does not come again: two thirds of it in a turn."""
    q, out = problem.q[:, WRIST] * 0.63, np.zeros(problem.q.shape)
    out[:, WRIST] = 2.5e-4 * (np.arcsin(0.95 * np.sin(5 * q)) + np.tanh(2 * np.sin(9 * q + 1)) * np.cos(q))
    return out


@pytest.mark.parametrize(("error", "around"), [(bumps, True), (elsewhere, False)])
def test_what_is_the_same_in_every_turn_is_known_in_turns_that_nobody_measured(error, around):
    q = np.vstack([postures(-250, 290, 150, seed=1), postures(290, 355, 40, seed=2)])
    campaign = measured("ur10", loads=(), q=q, joints=error, targets=1, seed=5)
    outcome = diagnose(campaign.some(np.arange(150)), test=campaign.some(np.arange(150, 190)))
    assert named(outcome.diagnosis) == {("joint_map", "wrist_1_joint"): "named"}
    (cause,) = outcome.diagnosis.causes
    assert ("around" in cause.variant) == around
    assert ("the same in every turn" in cause.sentence) == around
    assert (outcome.diagnosis.test.after_rms_mm < 1.3e3 * np.sqrt(3) * SIGMA) == around


def test_a_run_out_of_a_joint_that_turns_more_than_once_keeps_its_name():
    hidden = "gear_eccentricity:joint=wrist_1_joint,variant=1,amplitude=3e-4,phase=0.7"
    q = postures(-250, 290, 120, seed=3)
    told = diagnose(measured("ur10", (hidden,), loads=(), q=q, targets=1, seed=6)).diagnosis
    assert named(told) == {("gear_eccentricity", "wrist_1_joint"): "named"}


def test_only_joints_that_turn_more_than_once_have_such_maps_and_a_model_keeps_them():
    q = postures(-250, 290, 60, seed=4)
    problem = problem_of(measured("ur10", loads=(), q=q))
    around = [one for one in JointMap.sites(problem) if one.around]
    assert {one.where.joint for one in around} == {"wrist_1_joint"}
    assert not any(one.around for one in JointMap.sites(problem_of(measured("cylindrical", loads=()))))
    rng = np.random.default_rng(5)
    for one in around:
        values = rng.normal(0.0, one.sizes)
        kept, its = from_record(record(one, values), problem)
        assert kept == one
        here, later = (one.basis(turn, None, problem.arm.names) @ its for turn in (q, q + 2 * np.pi))
        np.testing.assert_allclose(here, later, atol=1e-15)
        np.testing.assert_array_equal(one.beyond(q + 2 * np.pi, problem.arm.names), 0.0)
        moved = one.basis(q, None, problem.arm.names) @ rng.normal(0.0, one.sizes, (400, len(one.sizes))).T
        assert moved.std() == pytest.approx(one.size, rel=0.1)
