"""A study's zip for others: data in the open, truth apart; tables as CSV and LaTeX."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from workbench import Truth, load_campaign, load_robot, planned, restated, simulate, stored, write_campaign
from workbench.cli.main import main
from workbench.report.study import Table
from workbench.report.study_exports import csv_text, latex_text
from workbench.studies.archive import SEALED, archive


@pytest.fixture
def results(tmp_path: Path) -> Path:
    folder = tmp_path / "reports" / "cylindrical"
    robot = load_robot("cylindrical")
    plan = planned(robot, np.random.default_rng(0).uniform(0, 0.5, (6, 3)), targets=())
    seen = simulate(planned(robot, plan.poses.q), Truth(sigma=1e-5))
    blind = stored(folder / "rigid" / "cylindrical.toml", restated(robot, stiffness=None))
    write_campaign(folder / "full", seen.__class__(**{**vars(seen), "robot": blind}))
    (folder / "truth.json").write_text(json.dumps({"campaigns": {"full/campaign.toml": {"stiffness": 1e6}}}))
    (folder / "result.json").write_text(json.dumps({"study": "cylindrical", "robot": "cylindrical"}))
    return folder


def test_the_archive_can_be_diagnosed_blind(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["study", "archive", "cylindrical"]) == 0
    assert capsys.readouterr().out == "wrote reports/cylindrical.zip\n"
    first = (tmp_path / "reports/cylindrical.zip").read_bytes()
    with zipfile.ZipFile(io.BytesIO(first)) as packed:
        packed.extractall(tmp_path / "away")
        names = set(packed.namelist())
    assert names == {"README.md", SEALED, "full/campaign.toml", "full/poses.csv", "full/points.csv",
                     "robots/full/robot.toml", "robots/full/cylindrical.urdf"}  # fmt: skip
    campaign = load_campaign(tmp_path / "away/full/campaign.toml")
    assert all(joint.data.stiffness is None for joint in campaign.robot.joints)
    np.testing.assert_array_equal(campaign.points, load_campaign(results / "full/campaign.toml").points)
    sealed = (tmp_path / "away" / SEALED).read_bytes()
    with zipfile.ZipFile(io.BytesIO(sealed)) as truth:
        assert json.loads(truth.read("truth.json"))["campaigns"]["full/campaign.toml"] == {"stiffness": 1e6}
    assert hashlib.sha256(sealed).hexdigest() in (tmp_path / "away/README.md").read_text()
    assert archive(results, tmp_path / "again.zip").read_bytes() == first


def test_without_results_there_is_nothing_to_pack(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "archive", "kr500", "--results", str(tmp_path)]) == 2
    assert "has no truth.json; run `workbench study NAME` first" in capsys.readouterr().err


def test_tables_leave_as_csv_and_latex() -> None:
    table = Table("A & B", ("Name", "Off by"), [["x_1", "−1\u202f234.5 ± 2 %"]], "10⁻⁹")
    assert list(csv.reader(io.StringIO(csv_text(table)))) == [["Name", "Off by"], ["x_1", "-1234.5 ± 2 %"]]
    text = latex_text(table)
    assert r"\caption{A \& B}" in text
    assert r"x\_1 & $-$1\,234.5 $\pm$ 2 \% \\" in text
    assert "10$^-$$^9$" in text
    assert r"\begin{tabular}{lr}" in text
