"""Campaigns that are fitted as one robot and are not of one: told, with what each by itself would leave."""

import re
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench.campaign import write_campaign
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.run import diagnose
from workbench.diagnosis.telling.set_ups_apart import perhaps_changed, set_ups_apart
from workbench.report.terminal import short_verdict


def test_campaigns_of_two_robots_are_told_with_what_each_alone_leaves(tmp_path):
    """Seeds draw the geometry: two specimens of a UR5."""
    paths = [
        write_campaign(tmp_path / name, measured("ur5", poses=40, loads=(), targets=2, seed=seed))
        for name, seed in (("first", 1), ("other", 2))
    ]
    outcome = diagnose(paths)
    (rest,) = [one for one in outcome.diagnosis.causes if one.structure]
    command = f"workbench compare {paths[0]} {paths[1]}"
    assert command in (rest.separate_by or "")
    assert command in short_verdict(outcome.diagnosis, None)
    (note,) = [one for one in outcome.diagnosis.notes if "fitted as one robot" in one]
    said = {
        name: (float(a), float(b))
        for name, a, b in re.findall(r"(first|other) ([.\d]+) mm \(([.\d]+) mm\)", note)
    }
    assert said.keys() == {"first", "other"}
    for together, alone in said.values():
        assert alone < 0.3 * together


def test_a_set_up_of_few_poses_is_not_among_those_that_are_fitted_by_themselves():
    campaign = measured("ur5", poses=40, loads=(), targets=2)
    few = replace(
        campaign.with_poses(setup=np.array([0] * 18 + [1] * 18 + [2] * 4)), setup_names=("a", "b", "c")
    )
    found = prepare(few).geometry
    assert {one.name for one in set_ups_apart(found)} == {"a", "b"}
    (said,) = perhaps_changed(found)
    assert "Of each that is fitted by itself as well is left, RMS (with geometry of its own): " in said
    assert not re.search(r"\bc [.\d]+ mm", said)
    many = replace(campaign.with_poses(setup=np.repeat(np.arange(8), 5)), setup_names=tuple("abcdefgh"))
    assert set_ups_apart(prepare(many).geometry) == []
    (said,) = perhaps_changed(prepare(many).geometry)
    assert "is left" not in said


def test_a_single_set_up_is_not_apart():
    assert set_ups_apart(diagnose(measured("ur5", poses=30, loads=(), targets=2)).fit) == []


def test_what_is_left_of_each_is_what_the_model_of_all_leaves_there():
    """Something sways in the order of measurement: found as that over all poses, it stays so in each."""
    campaign = measured("ur5", poses=60, loads=(), targets=2)
    sway = 1e-3 * np.sin(np.linspace(0.0, 9.0, 60))[:, None, None] * np.array([0.0, 0.6, 0.8])
    swaying = replace(
        campaign.with_poses(setup=np.repeat([0, 1], 30)),
        setup_names=("a", "b"),
        points=campaign.points + sway,
    )
    found = diagnose(swaying).fit
    off = found.residual.reshape(2, 30 * 2, 3)
    rms = [1e3 * np.sqrt(np.nanmean((one**2).sum(axis=1))) for one in off]
    left = dict(zip("ab", rms, strict=True))
    assert max(left.values()) < 0.3
    apart = set_ups_apart(found)
    assert {one.name for one in apart} == {"a", "b"}
    for one in apart:
        assert one.together_mm == pytest.approx(left[one.name])
        assert one.alone_mm < 1.01 * one.together_mm
