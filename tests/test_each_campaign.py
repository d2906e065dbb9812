"""Of several campaigns each has its figures: in `result.json`, on the terminal."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis_cases import measured, robot

from workbench.campaign.planned import random_poses
from workbench.diagnosis.run import diagnose
from workbench.report.terminal import short_verdict

COARSE = 1e-4  # m


@pytest.fixture(scope="module")
def joined():
    """Two campaigns of one robot, the second of a coarser instrument."""
    rng, each = np.random.default_rng(7), []
    for k, more in enumerate((0.0, COARSE)):
        exact = measured("cylindrical", q=random_poses(robot("cylindrical"), 30, rng), loads=())
        some = exact.some(np.arange(30 - 10 * k))
        points = some.points + more * rng.normal(size=some.points.shape)
        path = Path(f"c{k + 1}/campaign.toml")
        each.append(replace(some, title=f"c{k + 1}", path=path, points=points))
    coarse = replace(each[1], noise_sigma=float(np.hypot(COARSE, each[0].noise_sigma)))
    return diagnose([each[0], coarse])


def test_each_campaign_has_its_figures(joined):
    first, second = joined.diagnosis.to_json()["campaigns"]
    assert [one["campaign"] for one in (first, second)] == ["c1", "c2"]
    assert [(one["n_poses"], one["n_points"]) for one in (first, second)] == [(30, 90), (20, 60)]
    assert [one["of_model"] for one in (first, second)] == [False, True]
    assert first["noise"] == {"sigma_mm": pytest.approx(0.03), "source": "stated"}
    assert second["noise"]["sigma_mm"] == pytest.approx(1e3 * np.hypot(COARSE, 3e-5))
    for one in (first, second):
        left = 3**0.5 * one["noise"]["sigma_mm"]
        assert one["after_rms_mm"] == pytest.approx(left, rel=0.25)
        assert one["nominal_rms_mm"] > one["geometry_rms_mm"] > 0.7 * left
    points = sum(one["n_points"] * one["after_rms_mm"] ** 2 for one in (first, second))
    result = joined.diagnosis.to_json()
    assert (points / result["n_points"]) ** 0.5 == pytest.approx(result["stages"][-1]["fit_rms_mm"])


def test_the_terminal_has_a_line_for_each(joined):
    lines = short_verdict(joined.diagnosis, None).splitlines()
    first, second = (line for line in lines if line.startswith(("  c1 ", "  c2 ")))
    assert "30 poses   noise 0.030 " in first
    assert "the model is of this one" in second
    assert "the model is of" not in first


def test_a_single_campaign_has_none():
    one = diagnose(measured("cylindrical", poses=20, loads=())).diagnosis
    assert "campaigns" not in one.to_json()
    assert one.campaigns == ()
