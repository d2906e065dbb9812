"""What a link's own weight bends it by is what many small loads along it do."""

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench.campaign.problem import problem
from workbench.effects.link_bending import LinkBending
from workbench.effects.unnamed.loads import OwnWeight
from workbench.robot.beam import bending_compliance

PIECES = 400


@pytest.fixture(scope="module")
def read():
    return problem(measured("kr120", (), poses=12))


def test_it_is_the_sum_of_small_loads_along_the_link(read):
    for one in OwnWeight.sites(read):
        slot, weight = one.slot(read), one.across(read)
        span = read.arm.span[slot]
        sag = np.zeros((len(weight), 6))
        for share in (np.arange(PIECES) + 0.5) / PIECES:
            here = weight / PIECES @ bending_compliance(share * span)[:, :3].T  # where the piece hangs
            sag[:, :3] += here[:, :3] + np.cross(here[:, 3:], (1 - share) * span)  # straight from there on
            sag[:, 3:] += here[:, 3:]
        motion = one.motion(read)
        moved = np.concatenate([motion[6 * slot + k] for k in range(6)], axis=1) * one.largest
        np.testing.assert_allclose(moved, sag, atol=1e-4 * np.abs(sag).max())


def test_a_bending_link_brings_its_own_weight_and_no_more_than_hangs_on_it(read):
    found = {
        one.where.link: [(share, own) for share, own in one.companions(read) if isinstance(own, OwnWeight)]
        for one in LinkBending.sites(read)
    }
    assert {link for link, own in found.items() if own} >= {"link_2", "link_3"}
    for own in found.values():
        assert all(0 < share <= 1 for share, _ in own)
