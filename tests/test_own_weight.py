"""What a link's own weight bends it by is what many small loads along it do; and the compensator's force."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import measured

from workbench.campaign.problem import problem
from workbench.effects.link_bending import LinkBending
from workbench.effects.unnamed.link_ends import OwnWeight, PivotForce
from workbench.robot.beam import bending_compliance
from workbench.robot.loads import wrenches

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


def test_without_the_pivots_force_a_link_bends_as_if_there_were_no_compensator(read):
    """The cantilever under all that hangs on the link, less its companion, each over the same EI."""
    (bending,) = (one for one in LinkBending.sites(read) if one.where.link == "link_1")
    (share, force), *more = (
        (share, one) for share, one in bending.companions(read) if isinstance(one, PivotForce)
    )
    assert not more
    assert 0 < share <= 1
    slot = bending.slot(read.arm)
    alone = wrenches(read.arm, read.rigid, replace(read.loads, compensator=None)).local[:, slot]
    compliance = bending_compliance(read.arm.span[slot])
    motion = force.motion(read)
    moved = np.concatenate([motion[6 * slot + k] for k in range(6)], axis=1) * force.largest
    whole = read.nominal_load.local[:, slot] @ compliance.T
    np.testing.assert_allclose(whole - moved, alone @ compliance.T, atol=1e-9 * np.abs(whole).max())
    assert np.abs(moved).max() > 0.3 * np.abs(whole).max()
    others = [one for one in LinkBending.sites(read) if one.where != bending.where]
    assert not any(isinstance(c, PivotForce) for one in others for _, c in one.companions(read))
    assert not PivotForce.sites(problem(measured("ur5", (), poses=12, loads=())))
