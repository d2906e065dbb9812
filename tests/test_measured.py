"""A measured robot that anyone can diagnose again: 77 poses of a UR5 under a laser tracker."""

from __future__ import annotations

import csv
import json
import time
from pathlib import Path
from typing import get_args

import pytest

from workbench import Outcome, catalogue, diagnose, load_campaign
from workbench.diagnosis.result import Verdict

FOLDER = Path(__file__).parent / "data/ur5"
LONGEST = 240.0  # s of one processor, tenfold what it takes: a search that runs away is a fault


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    start = time.process_time()
    found = diagnose(load_campaign(FOLDER / "campaign.toml"))
    assert time.process_time() - start < LONGEST
    return found


def test_geometry_takes_most_of_the_error(outcome: Outcome) -> None:
    """Held out, over poses that the fit has not seen; the publisher's own calibration gains as much."""
    nominal, geometry, *_, last = (*outcome.diagnosis.stages, outcome.diagnosis.stages[-1])
    assert (nominal.name, geometry.name) == ("nominal", "geometry")
    assert 0.6 < nominal.heldout_rms_mm < 0.9
    assert geometry.heldout_rms_mm < nominal.heldout_rms_mm / 4
    assert last.heldout_rms_mm <= geometry.heldout_rms_mm


def test_the_result_is_complete(outcome: Outcome) -> None:
    """Every key is there, every number is one, and every cause is of the catalogue."""
    result = json.loads(json.dumps(outcome.diagnosis.to_json(), allow_nan=False))
    assert (result["schema"], result["n_poses"], result["n_points"]) == (1, 77, 77)
    assert {"robot", "noise", "stages", "verdict", "headline", "causes", "not_testable", "faults"} <= set(
        result
    )
    assert result["verdict"] in get_args(Verdict)
    assert {finding["cause"] for finding in result["causes"]} <= {*catalogue(), "unknown"}
    assert result["headline"]


def test_nothing_is_judged_that_was_not_measured(outcome: Outcome) -> None:
    """No side of approach, no temperature, no time: these causes say so."""
    blind = {"backlash", "thermal_growth", "drift"}
    assert blind <= {entry["cause"] for entry in outcome.diagnosis.to_json()["not_testable"]}
    assert not blind & {finding.cause for finding in outcome.diagnosis.causes}


def test_it_was_thinned_as_its_readme_says() -> None:
    with (FOLDER / "poses.csv").open() as file:
        assert [int(row["pose_id"]) for row in csv.DictReader(file)] == list(range(0, 1000, 13))
    assert "MIT License" in (FOLDER / "LICENSE").read_text()
