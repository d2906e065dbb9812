"""The cylindrical study: its intervals, its question, its circle."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from workbench.cli.main import main
from workbench.report.study import Study
from workbench.studies.cylindrical import printed
from workbench.studies.running import run_published
from workbench.studies.study_run import StudyRun


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cylindrical")


@pytest.fixture(scope="module")
def found(folder: Path) -> Study:
    (study,) = run_published(("cylindrical",), StudyRun(folder, quick=True))
    return study


def test_stiffness_is_found_within_what_the_noise_allows(found: Study) -> None:
    for j in (1, 2, 3):
        off, std = found.numbers[f"stiffness_{j}_off"], found.numbers[f"stiffness_{j}_half"] / 1.96
        assert 1e-3 < std < 8e-3  # physics: 0.2 to 0.6 % from 10 µm and 50 poses
        assert abs(off) < 4 * std


def test_stated_noise_cannot_make_the_printed_errors(found: Study) -> None:
    assert found.numbers["printed_off_in_sigma"] > 10
    assert 0.1 < found.numbers["noise_needed_mm"] < 1.0


def test_lever_and_force_make_all_three_errors(found: Study) -> None:
    off = printed.TABLE_2 / printed.TABLE_1 - 1
    made = [found.numbers[f"both_{j}_off"] for j in (1, 2, 3)]
    np.testing.assert_allclose(made, off, atol=5e-3)
    assert found.numbers["both_residual_p"] < 1e-3  # and the residual would have shown it


def test_compensation_brings_a_millimetre_down(found: Study) -> None:
    n = found.numbers
    assert 0.8 < n["uncompensated_mean_mm"] < 1.3  # the paper: about 1 mm
    assert n["ours_mean_mm"] < 0.01 < n["printed_mean_mm"] < 0.2


def test_tables_and_files_are_complete(found: Study, folder: Path) -> None:
    assert [len(table.rows) for table in found.tables] == [3, 6, 3]
    for name in ("index.html", "report.pdf", "scene.html", "result.json"):
        assert (folder / name).stat().st_size > 500, name
    assert json.loads((folder / "result.json").read_text())["numbers"] == pytest.approx(dict(found.numbers))
    for link in found.files.values():
        assert (folder / link).exists()


def test_a_study_by_name_gives_its_result_alone(
    found: Study, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def ran(names: tuple[str, ...], run: StudyRun) -> list[Study]:
        asked.append((names, run.folder, run.seed, run.quick, run.workers, run.resume))
        return [found]

    monkeypatch.setattr("workbench.studies.running.run_published", ran)
    assert (
        main(
            ["study", "cylindrical", "--quick", "--json", "--workers", "1", "--resume", "--out", str(folder)]
        )
        == 0
    )
    assert asked == [(("cylindrical",), folder, 0, True, 1, True)]
    result = json.loads(capsys.readouterr().out)
    assert (result["study"], result["robot"], result["schema"]) == ("cylindrical", "cylindrical", 1)
    assert json.loads((folder / "result.json").read_text(encoding="utf-8")) == result
    assert all(result["box"].values())
