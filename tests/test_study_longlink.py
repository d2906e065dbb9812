"""The long-link study: what the tables explain, what bends, what is identified, what would show load."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from workbench.campaign import load_campaign
from workbench.report.study import Study
from workbench.studies.longlink import printed
from workbench.studies.longlink import study as longlink
from workbench.studies.running import run_script
from workbench.studies.study_run import StudyRun


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("longlink")


@pytest.fixture(scope="module")
def found(folder: Path) -> Study:
    return run_script(longlink.study, StudyRun(folder, quick=True))


def test_geometry_alone_makes_the_printed_error(found: Study) -> None:
    n = found.numbers
    assert 24 < n["mean_90_mm"] < 27
    assert 28 < n["mean_45_mm"] < 31
    assert abs(n["mean_90_mm"] - printed.BEFORE) < n["scatter_90_mm"]
    assert n["share_alpha_1"] > 0.4  # one twist
    assert n["share_lengths"] < 0.05
    assert n["without_alpha_1_mm"] < printed.BEFORE - 2 * n["scatter_90_mm"]  # and it is no misprint


def test_links_of_the_printed_stiffness_bend_by_micrometres(found: Study) -> None:
    n = found.numbers
    assert 1e-3 < n["bending_own_mm"] < n["bending_loaded_mm"] < 0.1
    assert n["bending_eq21_mm"] < 0.1
    assert n["bending_loaded_mm"] < 0.01 * n["mean_90_mm"]
    assert n["sag_mm"] > 100 * n["bending_loaded_mm"]  # the joints as assumed


def test_sizes_that_leave_the_printed_error(found: Study) -> None:
    n = found.numbers
    assert 0.15 < n["share"] < 0.5  # stiffer than assumed is enough
    assert n["full_after_mm"] > 2 * printed.AFTER
    assert n["right_leaves_mm"] < 0.2  # and nothing wrong leaves nothing of it
    assert 1e-4 < n["ratio_leaves"] < 2e-3
    assert 0.01 < n["twist_leaves_deg"] < 0.1
    assert 0.3 < n["noise_leaves_mm"] < 2


def test_circle_points_hold_the_truth(found: Study) -> None:
    n = found.numbers
    assert n["circle_hits"] >= 0.85 * n["circle_intervals"]
    assert n["half_a_mm"] < 0.3
    assert n["bias_a_mm"] > 3 * n["half_a_mm"]  # deflection has to be taken out


def test_d_and_theta_are_identified(found: Study) -> None:
    n = found.numbers
    assert n["rank"] == 18  # of 20: not d₂ − d₃, not θ₇
    assert n["d_theta_hits"] >= 0.85 * n["d_theta_intervals"]
    assert n["d_theta_intervals"] == 12
    assert n["known_mean_mm"] < n["designed_mean_mm"] / 10
    assert n["rigid_mean_mm"] > 3 * n["known_mean_mm"]
    assert n["noise_mean_mm"] < 1.3 * n["together_mean_mm"] < 1.3 * n["known_mean_mm"]
    assert n["all_40_mean_mm"] < 0.15 < n["all_13_mean_mm"]
    assert n["sag_2_deg"] > 0.01  # downwards, as the printed θ₂
    assert n["sag_3_deg"] > 0.01


def test_two_loads_show_what_unloaded_poses_do_not(found: Study) -> None:
    n = found.numbers
    assert n["detectable_one"] > 1 > 2 * n["detectable_two"]  # the hidden excess is 1
    assert n["detectable_links"] < n["detectable_two"] < n["detectable_more"] < n["detectable_one"]
    assert n["gain_two"] > 2  # against as many unloaded points
    assert n["found_two"] > n["found_one"]
    assert n["named_two"] > n["named_more"]
    assert n["found_two"] == n["found_links"] == 1
    assert n["rigid_heldout_mm"] > 3 * n["noise_mean_mm"] > n["rigid_diagnosed_mm"]


def test_tables_and_files_are_complete(found: Study, folder: Path) -> None:
    lines = {table.title: len(table.rows) for table in found.tables}
    assert list(lines.values()) == [4, 10, 7, 6, 6, 7, 7, 8, 8, 4], lines
    assert len(found.figures) == 5
    for name in ("index.html", "report.pdf", "scene.html", "result.json"):
        assert (folder / name).stat().st_size > 500, name
    assert json.loads((folder / "result.json").read_text())["numbers"] == pytest.approx(dict(found.numbers))
    for link in found.files.values():
        assert (folder / link).exists()
    written = load_campaign(folder / "campaign" / "campaign.toml")
    assert len(written.poses.q) == 50
    stiffness = [joint.data.stiffness for joint in written.robot.joints]
    assert stiffness[1] == pytest.approx(2e5 / found.numbers["share"])
    assert np.isfinite(list(found.numbers.values())).all()
