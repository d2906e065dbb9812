"""A row that is there twice is one measurement."""

from dataclasses import replace

import numpy as np
from diagnosis_cases import measured

from workbench.campaign import load_campaign, write_campaign
from workbench.diagnosis.data_faults.copies import without_copies
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.run import diagnose


def test_copies_are_left_out_and_told_repeats_stay() -> None:
    campaign = measured("cylindrical", poses=12, loads=(), repeats=2)
    assert without_copies(campaign) == (campaign, ())
    n = len(campaign.poses)
    rows = np.array([*range(n), 3, 5])
    twice = campaign.some(rows).with_poses(ids=tuple(f"P{i}" for i in range(n + 2)))
    left, (fault,) = without_copies(twice)
    assert left.poses.ids == tuple(f"P{i}" for i in range(n))
    assert (fault.kind, fault.done) == ("copied_pose", "left out")
    assert "2 poses" in fault.what
    assert f"P{n}" in fault.what
    later = twice.with_poses(time=np.arange(n + 2.0))  # the same reading at another time is no copy of a row
    assert len(without_copies(later)[0].poses) == n + 2
    hidden = replace(twice, points=np.where(rows[:, None, None] == 3, np.nan, twice.points))
    assert len(without_copies(hidden)[0].poses) == n


def test_repeats_that_are_read_roughly_are_no_copies() -> None:
    """To 0.1 mm a few of them are alike in all numbers by chance; of those that are all alike none is."""
    campaign = measured("cylindrical", poses=30, loads=(), repeats=3, targets=1)
    rough = replace(campaign, points=np.round(campaign.points, 4))
    n = len(rough.poses)
    assert len(np.unique(rough.points.reshape(n, -1), axis=0)) < n - 10  # some are
    assert without_copies(rough) == (rough, ())
    once = np.unique(rough.poses.q, axis=0, return_index=True)[1]
    twice = rough.some(np.concatenate([once, once])).with_poses(ids=tuple(f"P{i}" for i in range(60)))
    assert len(without_copies(twice)[0].poses) == 30


def test_a_campaign_that_is_named_twice_by_another_name_is_no_second_one(tmp_path) -> None:
    campaign = measured("cylindrical", poses=20, loads=())
    part = campaign.some(np.arange(3, 20))
    paths = [write_campaign(tmp_path / name, c) for name, c in (("whole", campaign), ("part", part))]
    prepared = prepare([load_campaign(path) for path in paths])
    (fault,) = prepared.faults
    assert fault.kind == "copied_pose"
    assert "17 poses" in fault.what
    assert "part/4" in fault.what
    assert len(prepared.problem.q) == 20
    assert prepared.problem.campaign.setup_names == ("whole",)
    assert diagnose(paths).diagnosis.facts["Set-ups"] == "whole"
