"""The KR 500 study: cells where stiffness is constant, cells where something is missing, and the cause."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from workbench.campaign import load_campaign
from workbench.campaign.problem import problem_of
from workbench.effects.foundation import Foundation
from workbench.effects.joint_compliance import JointCompliance
from workbench.identification.cells import cells, fit_cells, load_cells
from workbench.identification.restated import restated
from workbench.report.study import Study
from workbench.robot.description import load_robot
from workbench.simulation.virtual_campaign import Truth, simulate
from workbench.studies.kr500 import printed
from workbench.studies.kr500 import study as kr500
from workbench.studies.kr500.count import Trade, trade
from workbench.studies.kr500.loads import exact, moved
from workbench.studies.kr500.missing import left_over
from workbench.studies.kr500.protocol import IN_BASE, plan
from workbench.studies.running import run_script
from workbench.studies.study_run import StudyRun


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("kr500")


@pytest.fixture(scope="module")
def found(folder: Path) -> Study:
    return run_script(kr500.study, StudyRun(folder, quick=True))


def test_cells_make_a_robot_of_constant_stiffness_worse(found: Study) -> None:
    n = found.numbers
    assert n["a_128_true_mm"] > 3 * n["a_same_true_mm"]  # the same measurements
    assert n["a_128_mm"] > n["a_same_mm"]  # and it can be seen through the noise
    assert n["a_allowed"] == 1
    assert 0.004 < n["a_128_true_mm"] < 0.02  # four numbers from 27 differences of 28 µm per axis


def test_cells_help_where_an_effect_is_missing(found: Study) -> None:
    n = found.numbers
    assert n["b_constant_mm"] > 1.05 * n["b_16_mm"] > 1.1 * n["b_128_mm"]
    assert abs(n["b_2_mm"] / n["b_constant_mm"] - 1) < 0.1  # left and right of the robot torques are the same
    assert n["b_same_true_mm"] > 1.5 * n["b_128_true_mm"]  # not because of more measurements
    assert n["b_allowed"] == 128
    allowed = [row[-1] for row in next(t for t in found.tables if "noise allows" in t.title).rows]
    assert allowed[0] == "128 or more"
    assert allowed[-1] == "1"
    assert 0 < n["b_pays"] < 0.5


def test_the_case_is_the_papers(found: Study) -> None:
    n = found.numbers
    assert n["b_raw_mm"] == pytest.approx(printed.ERRORS["raw"][0], rel=0.15)
    assert n["b_constant_mm"] == pytest.approx(printed.ERRORS["constant"][0], rel=0.15)
    assert n["floor_mm"] < n["b_named_mm"]
    assert n["b_kinematics_mm"] < n["printed_kinematics_mm"]  # what the paper gains by calibrating kinematics


def test_the_named_effect_beats_the_cells(found: Study) -> None:
    n = found.numbers
    assert n["named_records"] < n["records"] / 20
    assert n["b_named_mm"] < n["b_128_mm"]
    assert n["b_named_true_mm"] < n["b_128_true_mm"] / 1.5
    assert n["points_named_mm"] < n["points_128_mm"] < n["points_constant_mm"] < n["points_raw_mm"]
    assert n["line_named_max_mm"] < n["jump_mm"]
    verdicts = {row[0]: row[2:4] for row in next(t for t in found.tables if "diagnosis" in t.title).rows}
    assert verdicts["(a)"] == ["nothing missing", "none"]
    assert verdicts["(b)"] == ["named", "lost motion, joint 2"]


def test_a_hanging_mass_does_not_show_two_stiffnesses(found: Study) -> None:
    n = found.numbers
    assert [n[f"singular_{j}"] > 1 for j in range(1, 7)] == [True] * 4 + [False] * 2
    bounds = next(t for t in found.tables if "Least standard deviation" in t.title)
    assert [row[2] == "not seen" for row in bounds.rows] == [True, False, False, False, False, True]
    assert bounds.rows[0][3] != "not seen"  # from the side K1 is seen
    assert n["side_128_mm"] > n["side_raw_mm"] > 5 * n["side_named_mm"]


def test_tables_have_the_papers_rows(found: Study) -> None:
    rows = {table.title: len(table.rows) for table in found.tables}
    assert rows["Equations (18) to (21)"] == 12
    assert next(count for title, count in rows.items() if title.startswith("Table 1")) == 16
    assert next(count for title, count in rows.items() if "verification points" in title) == 8
    assert printed.TABLE_1.shape == (16, 6)
    np.testing.assert_allclose(printed.TABLE_1[:, 0].max(), 6.95e7)


def test_files_are_there_and_can_be_used(found: Study, folder: Path) -> None:
    for name in ("index.html", "report.pdf", "scene.html", "result.json"):
        assert (folder / name).stat().st_size > 500, name
    assert json.loads((folder / "result.json").read_text())["numbers"] == pytest.approx(dict(found.numbers))
    for link in found.files.values():
        assert (folder / link).exists()
    assert len(load_cells(folder / "cells/cells.toml").robots) == 128
    assert len(load_campaign(folder / "campaign/campaign.toml").poses.q) == found.numbers["named_records"]
    assert [e.cause for e in load_robot(folder / "model.toml").effects] == ["lost_motion"] * len(
        load_robot(folder / "model.toml").effects
    )


def test_number_of_cells_that_noise_allows() -> None:
    counts = np.array([1.0, 2.0, 16.0, 128.0])
    noise = 1e-12 * counts
    assert Trade(counts, np.zeros(4), noise).best == 1
    assert np.isinf(Trade(counts, np.zeros(4), noise).pays)
    assert Trade(counts, 1e-11 / counts**2, noise).best == 2
    falling = Trade(counts, 1e-6 / counts, noise)
    assert falling.best == 128
    assert falling.scaled(1e-3).best == 1
    assert falling.pays == pytest.approx(np.sqrt(127e-12 / (1e-6 - 1e-6 / 128)))


def test_trade_separates_noise_from_what_is_missing() -> None:
    rng = np.random.default_rng(0)
    true = rng.normal(size=(4000, 3))
    clean = [true + 0.3, true + 0.1]
    noisy = [[one + rng.normal(scale=s, size=one.shape) for one, s in zip(clean, (0.1, 0.2), strict=True)]]
    found = trade([1, 8], true, clean, noisy)
    np.testing.assert_allclose(found.bias, [0.27, 0.03])
    np.testing.assert_allclose(found.variance, [0.03, 0.12], rtol=0.05)


def test_size_of_an_effect_that_leaves_so_much() -> None:
    """A foundation of the size that is said leaves in Drake what it is said to leave."""
    box = np.array([[1.5, -0.3, 1.1], [1.9, 0.3, 1.5]])
    robot = restated(load_robot("kr500"), repeatability=None)
    ours = plan(robot, cells(box, (1, 1, 1)).samples)
    check = plan(robot, cells(box, (2, 2, 2)).samples, (0.0,))
    effect = Foundation.sites(problem_of(ours))[0]
    (one,) = left_over(ours, check, [effect], 2e-5)
    hidden = Truth(effects=((effect, np.array([one.size])),), sigma=1e-7, repeatability=np.zeros(6))
    model = fit_cells(simulate(ours, hidden, instrument=IN_BASE), box, (1, 1, 1), instrument=IN_BASE)
    true = moved(exact(check, hidden))
    assert np.linalg.norm(true, axis=1).mean() == pytest.approx(one.raw, rel=0.05)
    left = np.linalg.norm(true - model.deflection(check)[len(true) :], axis=1).mean()
    assert left == pytest.approx(2e-5, rel=0.3)  # the fit weighs K1 and K6 in, which the estimate leaves out
    springs = JointCompliance.sites(problem_of(ours))
    assert not left_over(ours, check, springs[:1], 2e-5)  # takes itself over
