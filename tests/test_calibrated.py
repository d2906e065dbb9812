"""Calibrated targets that are not where they are stated: what their distances can tell, and what not."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import found, measured, named, with_points

from workbench.campaign import Campaign
from workbench.campaign.calibrated import contradicted
from workbench.campaign.problem import problem_of

PLACES = (0.1e-3, -0.04e-3, 0.08e-3), (-0.05e-3, 0.12e-3, 0.02e-3), (0.03e-3, 0.06e-3, -0.11e-3)  # m off


def calibrated(scale: float = 0.0, misplaced: float = 0.0, seed: int = 4) -> Campaign:
    """Sound, of three calibrated targets: an instrument that shows all longer, and places that are off."""
    campaign = measured("irb120", poses=50, loads=(), seed=seed)
    targets = tuple(
        replace(target, fixed=True, xyz=tuple(np.array(target.xyz) + misplaced * np.array(off)))
        for target, off in zip(campaign.targets, PLACES, strict=True)
    )
    return replace(with_points(campaign, campaign.points * (1 + scale)), targets=targets)


@pytest.mark.parametrize("seed", range(4))
def test_distances_that_are_right_but_for_one_scale_agree(seed):
    for scale in (0.0, 1e-4, 1e-3, 1e-2):
        assert contradicted(problem_of(calibrated(scale, seed=seed))) is None


def test_misplaced_targets_contradict_what_was_measured():
    off = contradicted(problem_of(calibrated(misplaced=1.0)))
    assert off == pytest.approx(0.205e-3, rel=0.1)  # of T1 and T2
    assert contradicted(problem_of(calibrated(misplaced=0.3))) == pytest.approx(0.3 * 0.205e-3, rel=0.3)
    assert contradicted(problem_of(calibrated(misplaced=1e-3))) is None


def test_a_scale_stands_out_of_what_the_places_are_off():
    assert contradicted(problem_of(calibrated(scale=2e-2, misplaced=0.3))) is None


def test_two_targets_cannot_contradict_each_other():
    campaign = calibrated(misplaced=1.0)
    assert contradicted(problem_of(campaign.looking_at(("T1", "T2")))) is None


def test_misplaced_targets_are_told_and_are_no_scale():
    diagnosis = found(calibrated(misplaced=1.0))
    assert ("tracker_scale", "") not in named(diagnosis)
    why = {missing.cause: missing.why for missing in diagnosis.not_testable}
    assert "look at their places" in why["tracker_scale"]
    assert any("calibrated targets (fixed = true) are up to 0.2" in note for note in diagnosis.notes)


def test_a_scale_of_calibrated_targets_has_its_name():
    diagnosis = found(calibrated(scale=5e-4))
    assert named(diagnosis) == {("tracker_scale", ""): "named"}
    assert not any("fixed = true" in note for note in diagnosis.notes)
