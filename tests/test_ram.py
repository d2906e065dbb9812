"""A ram that slides out of its guide bends the more the further it stands out."""

import numpy as np
import pytest
from diagnosis_cases import found, measured, named, robot

from workbench.campaign.planned import planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.effects.link_bending import LinkBending
from workbench.robot.beam import bending_compliance
from workbench.robot.kinematics import RX

GUIDE, STIFFNESS, PIECES = 0.12, 6e4, 40  # m that the ram reaches into its guide; N·m²


def bends(problem):
    """The cylindrical robot's joint 3 slides a ram out of its guide: it bends in short pieces, each under the
    moment there, of its load and of its own weight beyond (it tapers)."""
    arm, load = problem.arm, problem.nominal_load.local[:, 4]
    axis = arm.R[4].T[:, 2]
    out = problem.q[:, 2] + arm.p[4, 2] + GUIDE
    beside = arm.span[4] - axis * (axis @ arm.span[4])
    shift, turn = np.zeros((2, len(out), 3))
    for piece in (np.arange(PIECES) + 0.5) / PIECES:
        to_end = np.outer(out * (1 - piece), axis) + beside
        moment = load[:, RX:] + np.cross(to_end, load[:, :RX])
        moment -= np.outer(moment @ axis, axis)
        bend = moment * (out / PIECES / STIFFNESS * (0.8 + 0.4 * piece))[:, None]
        turn += bend
        shift += np.cross(bend, to_end)
    return {24 + k: column for k, column in enumerate(np.concatenate([shift, turn], axis=1).T)}


def test_a_ram_of_one_length_bends_as_a_link_of_it():
    arm = robot("cylindrical")
    case = problem_of(
        planned(
            arm,
            np.tile([[0.3, 0.2, 0.35]], (2, 1)),
            payloads={"a": (20.0, (0.1, 0.05, 0.2))},
            payload=["", "a"],
        )
    )
    ram = next(one for one in LinkBending.places(case) if one.variant == "ram" and str(one.where) == "link_3")
    alone = bending_compliance(case.arm.R[4].T[:, 2] * float(ram.out(case)[0]))
    along = case.arm.R[4].T[:, 2]
    assert np.abs(case.arm.span[4] - along * (along @ case.arm.span[4])).max() < 1e-9
    assert np.abs(ram.moved(case) - case.nominal_load.local[:, 4] @ alone.T).max() < 1e-12
    assert {24 + k for k in range(6)} == set(ram.motion(case))


def test_rams_are_tested_where_they_stood_out_by_different_lengths():
    arm = robot("cylindrical")
    q = random_poses(arm, 12, np.random.default_rng(1))
    rams = {str(one.where) for one in LinkBending.sites(problem_of(planned(arm, q))) if one.variant == "ram"}
    assert "link_3" in rams
    q[:, 2] = 0.3
    still = problem_of(planned(arm, q))
    assert "link_3" not in {str(one.where) for one in LinkBending.sites(still) if one.variant == "ram"}
    assert "link_3" in {str(one.where) for one in LinkBending.places(still) if one.variant == "ram"}


def test_a_ram_that_bends_is_found_and_no_payload_or_other_link():
    told = found(measured("cylindrical", motion=bends, poses=60, loads=(12.0, 25.0), seed=2))
    assert set(named(told)) == {("link_bending", "link_3")}
    (cause,) = told.causes
    assert cause.probability > 0.8  # the rest is a guide or a carriage that tilts
    assert cause.variant.startswith("ram")
    assert "stands out" in cause.sentence
    assert 1 / cause.parameters[0].value == pytest.approx(STIFFNESS, rel=0.5)
