"""Repeated poses, told as ISO 9283 does."""

import re
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import SIGMA, measured

from workbench.campaign.problem import problem_of
from workbench.diagnosis.first_look import first_look
from workbench.files.faults import InputError
from workbench.identification.iso_9283 import repeatability
from workbench.identification.plausible import enough_poses
from workbench.report.first_look import check_campaign


@pytest.fixture(scope="module")
def cube():
    """Five positions, thirty times each."""
    return measured("irb120", poses=5, repeats=30, loads=(), targets=1, seed=3)


def test_the_spread_of_repeats_is_that_of_their_noise(cube):
    """Distances from the mean of a normal's points are Maxwell's."""
    found = repeatability(problem_of(cube))
    assert found.repeats.tolist() == [30] * 5
    assert not found.sides.size
    mean, std = np.sqrt(8 / np.pi), np.sqrt(3 - 8 / np.pi)
    assert found.rp.mean() == pytest.approx(SIGMA * (mean + 3 * std), rel=0.1)


def test_by_hand():
    """Five points on a line: distances 2 1 0 1 2, mean 1.2, standard deviation √0.7."""
    campaign = measured("irb120", poses=1, repeats=5, loads=(), targets=1)
    points = np.zeros((5, 1, 3))
    points[:, 0, 1] = 1e-4 * np.array([-2, -1, 0, 1, 2])
    (rp,) = repeatability(problem_of(replace(campaign, points=points))).rp
    assert rp == pytest.approx(1e-4 * (1.2 + 3 * np.sqrt(0.7)))
    points[0] = np.nan
    assert repeatability(problem_of(replace(campaign, points=points))) is None


def test_sides_of_approach_are_apart_by_what_plays(cube):
    side = np.ones_like(cube.poses.q)
    side[::2] = -1
    points = cube.points + np.where(side[:, :1, None] < 0, 3e-4, 0.0) * [0.6, 0.0, 0.8]
    found = repeatability(problem_of(replace(cube.with_poses(side=side), points=points)))
    assert len(found.rp) == 10
    assert found.sides == pytest.approx(np.full(5, 3e-4), abs=5 * SIGMA / np.sqrt(15))
    assert found.rp.mean() < 4.5 * SIGMA


def test_check_tells_it_and_a_refused_diagnosis_says_so(cube):
    checked = check_campaign(first_look(cube))
    assert "5 positions measured 30 times from one side: pose repeatability RP (ISO 9283) 0.1" in checked.text
    assert checked.facts["rp_mm"] == pytest.approx(0.12, abs=0.03)
    with pytest.raises(InputError, match=r"workbench check tells how they repeat"):
        enough_poses(problem_of(cube))
    assert re.search(
        r"they do not identify it; measure \d+ poses or more: [^;]*$", checked.text, re.MULTILINE
    )
    once = measured("irb120", poses=5, loads=(), targets=1)
    assert "9283" not in check_campaign(first_look(once)).text
    with pytest.raises(InputError, match=r"measure \d+ poses or more: workbench plan irb120 --poses \d+$"):
        enough_poses(problem_of(once))
