"""The KR 500 study: cells where stiffness is constant, cells where something is missing, and the cause."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from workbench.campaign import load_campaign
from workbench.cells import load_cells
from workbench.report.study import Study
from workbench.robot import load_robot
from workbench.studies import kr500
from workbench.studies.running import run


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("kr500")


@pytest.fixture(scope="module")
def found(folder: Path) -> Study:
    return run(kr500.study, folder, 0, True, lambda _: None)


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
    assert n["b_raw_mm"] == pytest.approx(0.2567, rel=0.15)
    assert n["b_constant_mm"] == pytest.approx(0.1049, rel=0.15)
    assert n["floor_mm"] < n["b_named_mm"]
    assert n["b_kinematics_mm"] < 0.0055  # what the paper gains by calibrating kinematics


def test_the_named_effect_beats_the_cells(found: Study) -> None:
    n = found.numbers
    assert n["named_records"] < n["records"] / 20
    assert n["b_named_mm"] < n["b_128_mm"]
    assert n["b_named_true_mm"] < n["b_128_true_mm"] / 1.5
    assert n["points_named_mm"] < n["points_128_mm"] < n["points_constant_mm"] < n["points_raw_mm"]
    assert n["line_named_max_mm"] < n["jump_mm"]
    verdicts = {row[0]: row[2:4] for row in next(t for t in found.tables if "diagnosis" in t.title).rows}
    assert verdicts["(a)"] == ["nothing missing", "none"]
    assert verdicts["(b)"] == ["named", "lost motion(joint 2)"]


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
    assert kr500.TABLE_1.shape == (16, 6)
    np.testing.assert_allclose(kr500.TABLE_1[:, 0].max(), 6.95e7)


def test_files_are_there_and_can_be_used(found: Study, folder: Path) -> None:
    for name in ("index.html", "report.pdf", "scene.html", "result.json"):
        assert (folder / name).stat().st_size > 500, name
    assert json.loads((folder / "result.json").read_text())["numbers"] == pytest.approx(dict(found.numbers))
    for link in found.files.values():
        assert (folder / link).exists()
    assert len(load_cells(folder / "cells/cells.toml").robots) == 128
    assert len(load_campaign(folder / "campaign/campaign.toml").q) == found.numbers["named_records"]
    assert [e.cause for e in load_robot(folder / "model.toml").effects] == ["lost_motion"] * len(
        load_robot(folder / "model.toml").effects
    )
