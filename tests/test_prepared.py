"""One preparation: a plan sees the data faults that a diagnosis sees, and starts from the same fit."""

import json
import re

import numpy as np
import pytest
from diagnosis_cases import measured, with_points

from workbench.campaign import write_campaign
from workbench.cli.main import main
from workbench.diagnosis.run import diagnose
from workbench.measurement.design import plan
from workbench.measurement.design.prior_information import from_campaign

LATE = 75  # poses before the instrument was moved


def untouched(points):
    pass


def moved(points):
    points[LATE:] += [8e-4, -6e-4, 0.0]


def wild(points):
    points[7, 1] += [0.2, 0, 0.1]


def swapped_and_moved(points):
    points[11, [0, 2]] = points[11, [2, 0]]
    moved(points)


def spoilt(change, **options):
    campaign = measured(**options)
    points = campaign.points.copy()
    change(points)
    return with_points(campaign, points)


def test_a_plan_takes_a_moved_instrument_for_two_set_ups(tmp_path, capsys):
    campaign = spoilt(moved)
    known = from_campaign(campaign)
    assert known.fit.chi2 / known.fit.point_rows < 1.2
    assert known.problem.campaign.poses.setup.tolist() == [0] * LATE + [1] * (len(campaign.poses.q) - LATE)
    (fault,) = plan(campaign, 8, quick=True).to_json()["faults"]
    assert (fault["kind"], fault["pose_id"]) == ("moved_instrument", str(LATE + 1))
    (size,) = re.findall(r"steps by (\S+) mm", fault["what"])
    assert float(size) == pytest.approx(1.0, abs=0.03)
    source, out = str(write_campaign(tmp_path, campaign)), str(tmp_path / "new.csv")
    call = ["plan", source, "--poses", "8", "--quick", "--out", out]
    assert main(call) == 0
    assert f"Data fault: moved_instrument at pose {LATE + 1}" in capsys.readouterr().out
    assert main([*call, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["faults"] == [fault]


@pytest.mark.parametrize(
    ("change", "options"),
    [
        (untouched, {"torque_sigma": 20.0}),
        (wild, {}),
        (moved, {"state_sigma": False}),
        (swapped_and_moved, {}),
    ],
    ids=["torque", "wild", "moved without noise", "swapped and moved"],
)
def test_plan_and_diagnosis_start_from_the_same(change, options):
    campaign = spoilt(change, **options)
    outcome, known = diagnose(campaign), from_campaign(campaign)
    assert outcome.diagnosis.verdict == "nothing_missing"  # so its last fit is that of the geometry
    ours, theirs = known.fit, outcome.fit
    assert np.array_equal(ours.model.problem.campaign.poses.setup, theirs.model.problem.campaign.poses.setup)
    np.testing.assert_array_equal(ours.model.problem.campaign.points, theirs.model.problem.campaign.points)
    assert np.array_equal(ours.state.geometry, theirs.state.geometry)
    assert np.array_equal(ours.noise.sigma, theirs.noise.sigma)
    assert np.array_equal(ours.noise.joint, theirs.noise.joint)
    assert np.array_equal(ours.whitener, theirs.whitener)
    assert known.faults == outcome.diagnosis.faults
