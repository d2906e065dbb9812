"""Commands that write: killed, on a full disk, where nobody may write, what was there before stays, whole."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import resource
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent / "robustness"))

from cases import seeds

from workbench.cli.main import main
from workbench.cli.status import guarded
from workbench.files.whole import TEMPORARY, settle
from workbench.simulation import processes
from workbench.studies.tasks import run_tasks

MODEL = ("--model", "model.toml", "--payload", "heavy")
SLOW = ("--quick", "--workers", "1", "--speed", "0.3", "--on-limit", "saturate")
CALLS = {
    "simulate": ("simulate", "tiny.toml", "--random", "6", "--out", "out"),
    "compensate": ("compensate", "joints.csv", *MODEL, "--format", "csv", "--force", "--out", "out/path.csv"),
    "plan": ("plan", "tiny.toml", "--quick", "--poses", "12", "--force", "--out", "out"),
    "export": ("export", "model.toml", "--to", "sdf", "--payload", "heavy", "--out", "out"),
    "diagnose": ("diagnose", "campaign.toml", "--out", "out"),
    "predict": ("predict", "found/model.toml", "--poses", "poses.csv", "--out", "out/predicted"),
    "verify": ("verify", "joints.csv", *MODEL, *SLOW, "--out", "out"),
    "study archive": ("study", "archive", "cylindrical", "--results", "found", "--out", "out/study.zip"),
}
ONCE = {  # what would take long twice, or cannot run twice into one folder
    "compare": ("compare", "campaign.toml", "later.toml", "--out", "out"),
    "init": ("init", "tiny.urdf", "--out", "out"),
}
PAGES = {  # page, numbers, and the inputs whose hashes they say
    "diagnose": ("index.html", "result.json", ("campaign.toml", "poses.csv", "points.csv", "tiny.urdf")),
    "plan": ("index.html", "plan.json", ("tiny.toml", "tiny.urdf")),
    "predict": ("predicted/index.html", "predicted/predict.json", ("found/model.toml", "poses.csv")),
    "verify": ("verify.html", "verify.json", ("joints.csv", "model.toml", "tiny.urdf")),
}
OLD = ("campaign.toml", "poses.csv", "path.csv", "index.html", "verify.html", "model.toml", "tiny.sdf")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with sound files, a diagnosis, and beside it what a study leaves."""
    here = tmp_path_factory.mktemp("sound")
    files = seeds(here)
    for name in ("poses.csv", "points.csv"):
        (here / name).write_text(files[f"more_{name}"])
    (here / "later.toml").write_text(files["campaign.toml"])
    with contextlib.chdir(here):
        assert main(["diagnose", "campaign.toml", "--out", "found"]) == 0
    (here / "found/truth.json").write_text('{"campaigns": ["../campaign.toml"]}')
    (here / "found/result.json").write_text('{"study": "cylindrical", "robot": "tiny"}')
    return here


def content(folder: Path) -> dict[str, bytes]:
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def moved(call: Sequence[str], folder: Path) -> list[str]:
    """The call with its result in another folder."""
    return [str(folder / word) if word.startswith("out") else word for word in call]


@contextlib.contextmanager
def files_below(size: int) -> Iterator[None]:
    """A full disk, as a limit of the size of a file: none can become as large as this [bytes]."""
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size - 1, usual[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)


@contextlib.contextmanager
def copies_at_every_step(folder: Path) -> Iterator[list[Path]]:
    """Copies of the folder before every write and every move: what a kill -9 there leaves."""
    left: list[Path] = []

    def after_a_copy(real: Callable[..., Any]) -> Callable[..., Any]:
        def step(*arguments: Any) -> Any:
            left.append(folder.with_name(f"left_{len(left)}"))
            shutil.copytree(folder, left[-1])
            return real(*arguments)

        return step

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "replace", after_a_copy(os.replace))
        patch.setattr(Path, "write_bytes", after_a_copy(Path.write_bytes))
        yield left


def settled(folder: Path) -> dict[str, bytes]:
    """What a reader finds there."""
    for place in (folder, *(path for path in folder.rglob("*") if path.is_dir())):
        settle(place)
    return {name: data for name, data in content(folder).items() if not TEMPORARY.fullmatch(Path(name).name)}


@pytest.mark.parametrize("name", CALLS)
def test_the_result_is_the_old_or_the_new(
    place: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    name: str,
) -> None:
    """Killed at any step of writing, and on a disk on which the largest file of the result has no room."""
    monkeypatch.chdir(place)
    call, out = moved(CALLS[name], tmp_path), tmp_path / "out"
    out.mkdir()
    for file in OLD:
        (out / file).write_text("old")
    before = content(out)
    with copies_at_every_step(out) as left:
        assert main(call) == 0
    after = content(out)
    states = [settled(folder) for folder in left]
    assert all(state in (before, after) for state in states)
    assert states[0] == before
    assert after != before
    if name in PAGES:
        page, numbers, read = PAGES[name]
        for file in read:
            digest = hashlib.sha256((place / file).read_bytes()).hexdigest()
            assert digest in after[page].decode()
            assert digest in json.loads(after[numbers])["inputs"].values()

    capsys.readouterr()
    with files_below(max(map(len, after.values()))):
        assert main(call) == 2
    assert "File too large" in capsys.readouterr().err
    assert content(out) == after


def test_the_same_bytes_from_this_process_and_from_another(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Results come in the order of the runs, whoever is done first: another process shows what two do."""
    spawn_pool = processes.spawn_pool
    monkeypatch.setattr(processes, "spawn_pool", lambda _: spawn_pool(1))
    monkeypatch.chdir(place)
    for workers in "12":
        call = [workers if word == "1" else word for word in moved(CALLS["verify"], tmp_path / workers)]
        assert main(call) == 0
    one, two = (content(tmp_path / workers) for workers in "12")
    assert one == two
    assert len(one) == 4


@pytest.mark.parametrize("name", ONCE)
def test_nothing_is_written_where_the_disk_is_full(
    place: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    name: str,
) -> None:
    monkeypatch.chdir(place)
    capsys.readouterr()
    with files_below(300):
        assert main(moved(ONCE[name], tmp_path)) == 2
    assert "File too large" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", [*CALLS, *ONCE])
def test_where_a_file_is_in_the_way_it_is_said_before_the_work(
    place: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    name: str,
) -> None:
    """Below a file nobody can make a folder, root neither."""
    monkeypatch.chdir(place)
    (tmp_path / "file").write_text("mine")
    capsys.readouterr()
    assert main(moved((CALLS | ONCE)[name], tmp_path / "file")) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    assert line.endswith("name another place with --out")
    assert content(tmp_path) == {"file": b"mine"}


def test_a_study_on_a_full_disk_keeps_what_is_done(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its tasks are rows of one file, which cannot grow any more."""
    store, keys = tmp_path / "draws.sqlite", [*"abcdefgh"]
    did: list[str] = []

    def work(key: str) -> str:
        did.append(key)
        return key * 20_000

    def run() -> None:
        run_tasks(work, keys, store, study={}, workers=1, resume=True)

    with files_below(90_000):
        assert guarded(run) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: {store}: ")
    before = len(did)
    assert 1 < before < len(keys)
    assert guarded(run) == 0
    assert did == [*keys[:before], *keys[before - 1 :]]


def test_an_assertion_of_drake_ends_a_command_and_shows_where_when_asked(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from pydrake.geometry import Box

    assert guarded(lambda: Box(0.0, 1.0, 1.0) and None) == 1
    assert "failed: SystemExit: Box(): condition" in capsys.readouterr().err
    monkeypatch.setenv("WORKBENCH_DEBUG", "1")
    with pytest.raises(AssertionError, match=r"Box\(\): condition"):
        guarded(lambda: Box(0.0, 1.0, 1.0) and None)
