"""Steps of base or tool while a robot was measured are in the bounds of what its model foretells."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import SIGMA, measured

from workbench.campaign.problem import problem_of
from workbench.campaign.stepped import split_campaign, together
from workbench.effects.place import Where
from workbench.effects.records import parse_effect
from workbench.effects.unnamed.campaign import ZeroInTime
from workbench.identification.fit import fit, refit
from workbench.identification.model import Model
from workbench.identification.noise import stated_noise
from workbench.identification.prediction.of_fit import uncertainty
from workbench.identification.prediction.unsteady import unsteady

STEP = 1.5e-4  # m


def fitted(campaign):
    problem = problem_of(campaign)
    return fit(Model(problem), noise=stated_noise(problem))


def strays(result):
    return unsteady(result, np.ones(result.model.problem.seen.shape[1], bool))


@pytest.fixture(scope="module")
def steady():
    return measured("ur5", loads=(), poses=60)


def stepped(campaign, step=STEP):
    points = campaign.points.copy()
    points[30:] += step * np.array([0.6, 0.0, 0.8])
    return split_campaign(replace(campaign, points=points), 30)


def test_set_ups_that_were_split_are_one_again(steady):
    twice = split_campaign(split_campaign(steady, 20), 40, 1)
    assert len(twice.setup_names) == 3
    whole = together(twice)
    assert whole.setup_names == steady.setup_names
    assert whole.poses.setup.tolist() == steady.poses.setup.tolist()
    assert together(steady) is steady


def test_a_step_in_the_middle_strays_by_half_to_either_side(steady):
    assert strays(fitted(steady)) == 0.0
    assert strays(fitted(split_campaign(steady, 30))) < 0.3 * SIGMA
    assert strays(fitted(stepped(steady))) == pytest.approx(STEP / 2 / np.sqrt(3), rel=0.1)


def test_an_instrument_that_was_pushed_is_no_habit(steady):
    assert strays(fitted(stepped(steady, 2e-3))) == 0.0


def test_bounds_have_what_strays(steady):
    calm, moved = (uncertainty(fitted(one)) for one in (steady, stepped(steady)))
    assert moved.rest > 2 * calm.rest
    assert moved.rest > 0.9 * STEP / 2 / np.sqrt(3)


def test_what_creeps_is_no_step(steady):
    """A model is written without it: what it does is in what that leaves."""
    timed = steady.with_poses(time=60.0 * np.arange(len(steady.poses)))
    problem = problem_of(timed)
    drift = parse_effect("drift:variant=shift", problem)[0]
    zero = next(e for e in ZeroInTime.sites(problem) if e.where == Where(joint="shoulder_lift_joint"))
    plain = fitted(timed)
    assert strays(refit(plain, [drift])) == 0.0
    assert strays(refit(plain, [zero])) < 0.3 * SIGMA
