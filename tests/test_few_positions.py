"""Few joint positions, each measured many times on end: as many looks at the robot as there are positions."""

import numpy as np
import pytest
from diagnosis_cases import robot

from workbench import Truth, planned, problem_of, random_poses, simulate
from workbench.diagnosis.data_faults.moved_setup import _scatter
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.search.competition import Selection
from workbench.diagnosis.search.worth import _without_chance
from workbench.effects.unnamed import unnamed
from workbench.effects.unnamed.campaign import Clock
from workbench.identification.fit import refit


def lacking(problem):
    """Errors of two joints that no model of this campaign has."""
    out, q = np.zeros_like(problem.q), problem.q
    out[:, 1] = 5e-4 * np.sin(2 * q[:, 0] + 0.4) * np.cos(2 * q[:, 3] - 0.3)
    out[:, 2] = 5e-4 * np.sin(q[:, 0] + 1.0) * np.cos(2 * q[:, 4])
    return out


def repeated(name, positions, times, seed, joints=lacking, in_order=True, moved=None):
    """Random positions, each measured so many times on end, in the order of joint 1 if asked for."""
    arm = robot(name)
    q = random_poses(arm, positions, np.random.default_rng(seed))
    q = np.repeat(q[np.argsort(q[:, 0])] if in_order else q, times, axis=0)
    truth = Truth(joints=joints, motion=moved, sigma=1e-5, repeatability=np.full(6, 1e-5))
    return simulate(planned(arm, q), truth, seed=seed)


@pytest.mark.parametrize(("name", "positions", "seed"), [("kr500", 20, 0), ("kr500", 20, 8), ("6R", 24, 9)])
def test_what_a_model_lacks_is_no_step_for_being_measured_again_and_again(name, positions, seed):
    assert prepare(repeated(name, positions, 10, seed)).faults == ()


def test_a_step_stands_out_of_what_is_the_same_in_repeats_as_of_one_look():
    """What the model lacks weighs three times as much where each position is measured three times as often:
    so must a step. What scatters from repeat to repeat does not."""

    def out_of(times, joints):
        return _scatter(prepare(repeated("6R", 24, times, 9, joints)).geometry, 0.0)

    assert 2 < out_of(12, lacking) / out_of(4, lacking) < 4
    assert out_of(12, None) < 2


def test_a_tool_that_moved_between_repeated_positions_is_a_step():
    def moved(problem):
        late = (np.arange(len(problem.q)) >= 112).astype(float)
        return {6 * (problem.arm.n + 1): 3e-4 * late}

    (fault,) = prepare(repeated("6R", 60, 4, 3, joints=None, moved=moved)).faults
    assert (fault.kind, fault.pose_id) == ("changed_setup", "113")


def test_targets_do_not_sit_elsewhere_by_what_a_model_lacks():
    def joints(problem):
        out, q = np.zeros_like(problem.q), problem.q
        out[:, 0] = 5e-4 * np.sin(2.3 * q[:, 1] + 0.4) * np.cos(2 * q[:, 2] - 0.3)
        out[:, 2] = 5e-4 * np.sin(3 * q[:, 0] + 1) * np.cos(2 * q[:, 1])
        return out

    assert prepare(repeated("ur5", 20, 8, 1, joints, in_order=False)).faults == ()


def test_functions_of_order_are_no_sharper_than_positions_follow_each_other():
    def waves(positions, times):
        problem = problem_of(repeated("ur5", positions, times, 1, joints=None))
        return {one.highest for one in unnamed(problem) if type(one) is Clock}

    assert waves(80, 1) == {10}
    assert waves(24, 4) == {4}
    assert waves(4, 5) == set()


def test_free_functions_that_bend_to_one_position_alone_are_left_out(monkeypatch):
    """The mean of squares is better for one position, while most of the others are farther off."""
    from workbench.diagnosis.search import worth

    geometry = prepare(repeated("ur5", 14, 4, 2)).geometry
    function = next(iter(unnamed(geometry.model.problem)))
    selection = Selection(refit(geometry, [function]), (), (), (), None, (), np.zeros(6))  # type: ignore[arg-type]
    positions = np.arange(14)

    def of_positions(least):
        def held(fit, seed, out):
            return np.where(positions == 0, 9.0, 1.0) if len(out) else np.where(positions == 0, 1.0, least)

        monkeypatch.setattr(worth, "_of_positions", held)
        return _without_chance(selection, 1.0, 0)[0].fit.model.effects

    assert of_positions(1.3) == ()
    assert of_positions(0.8) == (function,)
