"""One of several campaigns states no noise: its own is found, the others keep what they state."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis_cases import measured, robot

from workbench.campaign import join
from workbench.campaign.planned import random_poses
from workbench.diagnosis.noise.noise_choice import as_left
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.run import diagnose

STATED, SILENT = 3e-5, 1.2e-4  # m
RUN_OUT = "gear_eccentricity:joint=elbow_joint,variant=2,amplitude=4e-4,phase=0.4"


def one_silent(effects=(), poses=(40, 40), repeats=(1, 1), targets=3):
    """Of one robot."""
    rng = np.random.default_rng(3)
    for k, (sigma, count, times) in enumerate(zip((STATED, SILENT), poses, repeats, strict=True)):
        q = random_poses(robot("ur5"), 40, rng)
        exact = measured("ur5", effects, q=q, loads=(), sigma=1e-9, repeats=times, targets=targets)
        exact = exact.some(np.arange(times * count))
        points = exact.points + sigma * rng.normal(size=exact.points.shape)
        said = None if k else sigma
        path = Path(f"c{k + 1}/campaign.toml")
        yield replace(exact, title=f"c{k + 1}", path=path, points=points, noise_sigma=said)


def noise_of(prepared):
    """[m] of each campaign."""
    sigma, of = prepared.covariance.sigma, prepared.problem.campaign.of_campaign
    return [float(np.sqrt(np.mean(sigma[of == k] ** 2))) for k in (0, 1)]


@pytest.mark.parametrize("repeats", [(1, 1), (1, 3)])
def test_the_silent_one_has_its_own_noise_and_the_other_what_it_states(repeats):
    prepared = prepare(list(one_silent(repeats=repeats)))
    stated, own = noise_of(prepared)
    assert stated == pytest.approx(STATED)
    assert own == pytest.approx(SILENT, rel=0.15)
    assert prepared.noise.source == "stated"


def test_what_a_cause_leaves_does_not_count_as_its_noise():
    """A single target has no distances that would show it."""
    outcome = diagnose(list(one_silent((RUN_OUT,), targets=1)))
    before = prepare(list(one_silent((RUN_OUT,), targets=1)))
    stated, own = noise_of(outcome.prepared)
    assert noise_of(before)[1] > 1.15 * own
    assert stated == pytest.approx(STATED)
    assert own == pytest.approx(SILENT, rel=0.15)
    assert outcome.diagnosis.noise.sigma_mm == pytest.approx(1e3 * outcome.prepared.covariance.usual)
    said = [note for note in outcome.prepared.notes if "where none is stated" in note]
    assert said == [
        f"Taken for noise where none is stated: {1e3 * own:.4f} mm per axis in c2, which the model leaves "
        "there; the others count as stated."
    ]
    assert {finding.cause for finding in outcome.diagnosis.causes} == {"gear_eccentricity"}
    assert "c2: 40 poses" in outcome.diagnosis.facts["Set-ups"]


@pytest.mark.parametrize("said", [True, False])
@pytest.mark.parametrize("poses", [(40, 20), (40, 8)])
def test_points_of_a_coarser_instrument_are_not_wild_for_that(poses, said):
    """Its own noise says what is wild in a campaign, stated or not."""
    fine, coarse = one_silent(poses=poses, targets=1)
    rng = np.random.default_rng(1)
    points = coarse.points + 2 * SILENT * rng.normal(size=coarse.points.shape)
    coarse = replace(coarse, points=points, noise_sigma=5**0.5 * SILENT if said else None)
    assert prepare([fine, coarse]).faults == ()


def test_of_few_poses_it_is_what_the_model_of_all_leaves():
    prepared = prepare(list(one_silent(poses=(40, 12), targets=1)))
    finer = prepared.with_silent(prepared.geometry)
    assert finer is not None
    stated, own = noise_of(finer)
    assert stated == pytest.approx(STATED)
    assert own == pytest.approx(SILENT, rel=0.25)


def test_measured_noise_of_the_silent_one_is_said_and_kept():
    prepared = prepare(list(one_silent(repeats=(1, 3))))
    assert prepared.problem.campaign.silent == ()
    assert prepared.with_silent(prepared.geometry) is None
    (said,) = (one for one in prepared.problem.campaign.warnings if "c2 states no noise" in one)
    assert "as it is measured there" in said


def test_where_none_states_a_noise_it_is_that_of_all():
    first, second = one_silent()
    prepared = prepare([replace(first, noise_sigma=None), second])
    assert prepared.noise.source == "residual"
    assert join([first, second]).silent == ("c2",)


def test_what_a_fit_leaves_is_counted_without_what_it_took():
    """Of the noise as it is, one: few poses are fitted by much of the model."""
    prepared = prepare(measured("ur5", q=random_poses(robot("ur5"), 30, np.random.default_rng(6)), loads=()))
    every = np.ones(30, dtype=bool)
    assert as_left(prepared.geometry, every) == pytest.approx(1.0, abs=0.12)
    few = every.copy()
    few[3:] = False
    assert as_left(prepared.geometry, few) == pytest.approx(1.0, abs=0.5)
