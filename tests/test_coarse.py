"""A machine that cables drive: its errors are a hundred times those of an industrial arm."""

import numpy as np
import pytest

from workbench import Truth, diagnose, load_robot, planned, random_poses, simulate
from workbench.campaign.planned import TARGETS
from workbench.campaign.problem import problem_of
from workbench.diagnosis.prepared import prepare
from workbench.simulation.virtual_campaign import random_geometry

PLAY = 12e-3  # rad


def measured(name, seed, times, play=0.0, poses=70):
    """A campaign of an arm whose joints all err by maps of their own, `times` as large as usual, and whose
    third has a play, not the same all around."""
    robot = load_robot(name)
    rng = np.random.default_rng(seed)
    q = random_poses(robot, poses, rng)
    side = rng.choice([-1.0, 1.0], size=q.shape)
    plan = planned(robot, q, targets=TARGETS[:3], direction=side)
    phase, size = rng.uniform(0, 6.3, (2, q.shape[1])), rng.uniform(0.3, 1.0, q.shape[1])

    def off(job):
        maps = times * 2e-5 * size * (np.sin(3 * q + phase[0]) + 0.5 * np.sin(1.7 * q + phase[1]))
        maps[:, 2] -= play * side[:, 2] * (1 + 0.2 * np.sin(q[:, 2] + 1.0))
        return maps

    truth = Truth(geometry=random_geometry(problem_of(plan).arm, rng), joints=off, sigma=times * 5e-6)
    return simulate(plan, truth, seed=seed)


def test_an_industrial_arm_is_not_coarse():
    assert prepare(measured("irb120", 3, times=1.0, play=60e-6)).problem.coarse == 1.0


@pytest.mark.parametrize(("name", "seed"), [("irb120", 4), pytest.param("ur5", 5, marks=pytest.mark.slow)])
def test_the_play_of_a_coarse_machine_has_its_name(name, seed):
    outcome = diagnose(measured(name, seed, times=100.0, play=PLAY))
    assert outcome.problem.coarse > 10
    assert any("industrial arm" in note for note in outcome.diagnosis.notes)
    play = next(cause for cause in outcome.diagnosis.causes if cause.cause == "backlash")
    assert (play.where.joint, play.status) == (outcome.problem.arm.names[2], "named")
    assert play.parameters[0].value == pytest.approx(PLAY, rel=0.15)


def test_a_coarse_machine_without_a_play_has_none_named():
    found = diagnose(measured("irb120", 6, times=100.0)).diagnosis
    assert "backlash" not in {cause.cause for cause in found.causes if cause.status == "named"}
