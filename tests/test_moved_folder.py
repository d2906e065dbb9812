"""A folder of results is whole: moved, with everything gone that it was made from, it still works."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "robustness"))

from cases import JOINT_PATH, TINY_TOML, TINY_URDF

from workbench.cli.main import main


@pytest.fixture(scope="module")
def moved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results made from a robot of the user's own, moved, and the robot deleted."""
    made, away = tmp_path_factory.mktemp("made"), tmp_path_factory.mktemp("away") / "archive"
    (made / "robot").mkdir()
    (made / "robot/tiny.urdf").write_text(TINY_URDF)
    (made / "robot/tiny.toml").write_text(TINY_TOML)
    robot, results = made / "robot/tiny.toml", made / "results"
    call = ["simulate", str(robot), "--random", "25", "--seed", "4", "--out", str(results / "campaign")]
    assert main([*call, "--effect", "gear_eccentricity:joint=joint_1,variant=1,amplitude=5e-4"]) == 0
    assert main(["diagnose", str(results / "campaign/campaign.toml"), "--out", str(results / "found")]) == 0
    shutil.move(results, away)
    shutil.rmtree(made)
    (away / "path.csv").write_text(JOINT_PATH)
    return away


def test_its_campaign_is_diagnosed_again(moved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", str(moved / "campaign/campaign.toml"), "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    before = json.loads((moved / "found/result.json").read_text())
    assert again["headline"] == before["headline"]
    assert [one["cause"] for one in again["causes"]] == ["gear_eccentricity"]


@pytest.mark.parametrize(
    "call",
    [
        ("simulate", "found/model.toml", "--random", "3", "--out", "again"),
        ("compensate", "path.csv", "--model", "found/model.toml"),
        ("predict", "found/model.toml", "--poses", "campaign/poses.csv"),
    ],
    ids=lambda call: call[0],
)
def test_its_model_is_used(moved: Path, call: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(moved)
    assert main(call) == 0
    for file in moved.rglob("*.toml"):
        assert ".." not in file.read_text()
