"""Readings of a joint that stood still while the arm moved on."""

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench.diagnosis.prepared import prepare


@pytest.mark.parametrize("count", [0, 7])
def test_a_joint_that_stood_still_is_told(count):
    campaign = measured("6R", poses=60, loads=())
    q = campaign.poses.q.copy()
    q[30 : 30 + count, 3] = q[30, 3]
    prepared = prepare(campaign.with_poses(q=q))
    said = [note for note in prepared.notes if "reads the same" in note]
    assert len(said) == (count > 0)
    for note in said:
        assert note.startswith(prepared.problem.arm.names[3] + " reads the same in ")
        assert np.isfinite(prepared.problem.campaign.points).all(axis=2).any(axis=1).sum() >= 52
