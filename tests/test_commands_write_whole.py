"""Commands that write, on a full disk: what was there before stays, whole."""

from __future__ import annotations

import contextlib
import resource
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "robustness"))

from cases import seeds

from workbench.cli.main import main

MODEL = ("--model", "model.toml", "--payload", "heavy")
CALLS = {
    "simulate": ("simulate", "tiny.toml", "--random", "6", "--out", "out"),
    "compensate": ("compensate", "joints.csv", *MODEL, "--format", "csv", "--out", "out/path.csv"),
    "plan": ("plan", "tiny.toml", "--quick", "--poses", "12", "--out", "out"),
    "export": ("export", "model.toml", "--to", "sdf", "--payload", "heavy", "--out", "out"),
    "diagnose": ("diagnose", "campaign.toml", "--out", "out"),
    "predict": ("predict", "found/model.toml", "--poses", "poses.csv", "--out", "out/predicted.csv"),
}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with sound files and a diagnosis."""
    here = tmp_path_factory.mktemp("sound")
    files = seeds(here)
    for name in ("poses.csv", "points.csv"):
        (here / name).write_text(files[f"more_{name}"])
    with contextlib.chdir(here):
        assert main(["diagnose", "campaign.toml", "--out", "found"]) == 0
    return here


def content(folder: Path) -> dict[str, bytes]:
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


@pytest.mark.parametrize("name", CALLS)
def test_the_old_result_stays_where_the_disk_is_full(
    place: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    name: str,
) -> None:
    """As a limit of the size of a file, which the largest of the result is beyond."""
    monkeypatch.chdir(place)
    call = [str(tmp_path / "out" / word[4:]) if word.startswith("out") else word for word in CALLS[name]]
    assert main(call) == 0
    before = content(tmp_path / "out")
    assert before
    call += ["--force"] if name == "compensate" else []
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    capsys.readouterr()
    resource.setrlimit(resource.RLIMIT_FSIZE, (max(map(len, before.values())) - 1, usual[1]))
    try:
        status = main(call)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)
    assert status == 2
    assert "File too large" in capsys.readouterr().err
    assert content(tmp_path / "out") == before
