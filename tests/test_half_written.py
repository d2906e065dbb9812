"""Killed, full, forbidden, two at once: the result folder is the old one or the new one."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from workbench.campaign import load_campaign
from workbench.campaign.planned import planned
from workbench.campaign.write import write_campaign
from workbench.cli.main import main
from workbench.files.faults import InputError, read_text
from workbench.files.whole import gathered, put, put_all
from workbench.report.study import Study
from workbench.robot.description import load_robot
from workbench.studies.running import run_script
from workbench.studies.study_run import StudyRun
from workbench.studies.tasks import run_tasks

ROOT = Path(__file__).resolve().parents[1]
NAMES = ("poses.csv", "points.csv", "deep/picture.svg", "campaign.toml")
SIMULATE = ("simulate", "cylindrical", "--random", "12", "--out")

# writes one generation of a result after the other, without end: all files at once, or each by itself
WRITER = """
import sys
from itertools import count
from pathlib import Path
from workbench.files.whole import gathered, put, put_all
folder, who, way = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
for generation in count():
    text = f"{who}{generation}\\n" * 3000
    if way == "together":
        put_all({folder / name: text for name in sys.argv[4:]})
    else:
        with gathered(folder) as made:
            for name in sys.argv[4:]:
                put(made / name, text)
    (folder.parent / f"{who}.started").touch()
"""


def whole(folder: Path) -> str:
    """What all files of the folder say alike, which must be whole, with nothing else beside them."""
    for part in (folder, folder / "deep"):
        put(part / "another", "")  # whoever writes here next leaves it clean
        (part / "another").unlink()
    texts = {read_text(folder / name) for name in NAMES}
    assert len(texts) == 1
    (text,) = texts
    assert len(set(text.splitlines())) == 1
    assert text.count("\n") == 3000
    assert {path.relative_to(folder).as_posix() for path in folder.rglob("*")} == {*NAMES, "deep"}
    return text.split("\n", 1)[0]


def writer(folder: Path, who: str, way: str = "together") -> subprocess.Popen[bytes]:
    (folder.parent / f"{who}.started").unlink(missing_ok=True)
    command = [sys.executable, "-c", WRITER, str(folder), who, way, *NAMES]
    return subprocess.Popen(command, env={**os.environ, "PYTHONPATH": str(ROOT)})


def wait_for(*files: Path) -> None:
    until = time.monotonic() + 60
    while not all(file.exists() for file in files) and time.monotonic() < until:
        time.sleep(0.005)


@pytest.mark.parametrize("way", ["together", "one by one"])
@pytest.mark.parametrize("seed", range(6))
def test_killed_at_any_time(tmp_path: Path, seed: int, way: str) -> None:
    running = writer(tmp_path / "out", "a", way)
    wait_for(tmp_path / "a.started")
    time.sleep(random.Random(seed).uniform(0, 0.02))
    running.kill()
    running.wait()
    assert whole(tmp_path / "out").startswith("a")
    put(tmp_path / "another", "")  # whoever writes beside it next leaves that clean
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("moves", range(len(NAMES) + 2))
def test_killed_between_two_moves(tmp_path: Path, moves: int) -> None:
    """The list of moves is itself moved into place: killed before that, the result is the old one."""
    put_all({tmp_path / name: "old\n" * 3000 for name in NAMES})
    child = os.fork()
    if child == 0:
        done, real = [], os.replace

        def replace(source: Path, target: Path) -> None:
            if len(done) == moves:
                os._exit(9)
            done.append(target)
            real(source, target)

        os.replace = replace  # type: ignore[assignment]
        put_all({tmp_path / name: "new\n" * 3000 for name in NAMES})
        os._exit(9)
    os.waitpid(child, 0)
    assert read_text(tmp_path / "poses.csv").startswith("new" if moves else "old")
    assert whole(tmp_path) == ("new" if moves else "old")


def test_a_list_of_moves_reaches_nothing_outside(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in/.0123456789abcdef.part").write_text("evil")
    (tmp_path / "in/.unfinished").write_text('[[".0123456789abcdef.part", "../x"], ["a", "b"], 7]')
    (tmp_path / "in/a").write_text("a")
    assert read_text(tmp_path / "in/a") == "a"
    assert sorted(path.name for path in tmp_path.rglob("*") if path.is_file()) == [
        ".0123456789abcdef.part",
        "a",
    ]


@pytest.mark.parametrize("way", ["together", "one by one"])
def test_two_runs_into_one_folder(tmp_path: Path, way: str) -> None:
    both = [writer(tmp_path / "out", who, way) for who in "ab"]
    wait_for(tmp_path / "a.started", tmp_path / "b.started")
    time.sleep(0.2)
    for running in both:
        running.kill()
        running.wait()
    assert whole(tmp_path / "out")[0] in "ab"


def test_a_full_disk_leaves_the_old_campaign(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As a limit of the size of a file; poses.csv is below it, points.csv beyond."""
    out = tmp_path / "out"
    assert main([*SIMULATE, str(out)]) == 0
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    limited = (
        "import resource, sys; from workbench.cli.main import main; "
        f"resource.setrlimit(resource.RLIMIT_FSIZE, (1500, 1500)); sys.exit(main({[*SIMULATE, str(out)]!r}))"
    )
    done = subprocess.run([sys.executable, "-c", limited], capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    assert "File too large; make room, or name another place with --out" in done.stderr
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    assert len(before["poses.csv"]) < 1500 < len(before["points.csv"])
    assert load_campaign(out / "campaign.toml").n_poses == 12


def drawing(run: StudyRun) -> str:
    """A script up to its end: it draws, and writes a file of its result."""
    done = run_tasks(str.upper, ["a"], run.store("draws"), study={}, workers=1, resume=run.resume)
    write_campaign(run.folder / "campaign", planned(load_robot("cylindrical"), np.zeros((1, 3))))
    put(run.folder / "model.toml", "new")
    return str(done["a"].result)


def test_a_study_that_is_killed_leaves_the_old_result_and_its_draws(tmp_path: Path) -> None:
    put(tmp_path / "out/model.toml", "old")
    child = os.fork()
    if child == 0:
        run_script(lambda run: os._exit(len(drawing(run))), StudyRun(tmp_path / "out"))
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1  # the draw was there
    assert read_text(tmp_path / "out/model.toml") == "old"
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"model.toml", "draws"}
    assert len(list(tmp_path.glob(".*"))) == 1

    def nothing_is_drawn(key: str) -> str:
        raise AssertionError(key)

    def resumed(run: StudyRun) -> Study:
        store = run_tasks(nothing_is_drawn, ["a"], run.store("draws"), study={}, workers=1, resume=True)
        assert store["a"].result == "A"
        drawing(run)
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space left"):
        run_script(resumed, StudyRun(tmp_path / "out", resume=True))
    assert read_text(tmp_path / "out/model.toml") == "old"
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"model.toml", "draws"}
    assert not list(tmp_path.glob(".*"))


def test_a_study_writes_in_its_folder_where_nobody_may_write_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != tmp_path)
    with gathered(out) as made:
        assert made.parent == out
        put(made / "deep/model.toml", "new")
        put(out / "another", "")  # which leaves alone what is in use
        assert (made / "deep/model.toml").exists()
    assert sorted(path.name for path in out.rglob("*")) == ["another", "deep", "model.toml"]


@pytest.mark.parametrize("out", ["/proc/nowhere/out", "file/out"])
def test_where_nobody_may_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], out: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    assert main([*SIMULATE, out]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    assert line.endswith("name another place with --out")
    assert os.listdir(tmp_path) == ["file"]


def test_what_a_killed_process_left_and_nobody_may_move_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / ".unfinished").write_text('[[".0123456789abcdef.part", "poses.csv"]]')
    (tmp_path / ".0123456789abcdef.part").write_text("new")
    (tmp_path / "poses.csv").write_text("old")

    def forbidden(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", forbidden)
    with pytest.raises(InputError, match="Permission denied"):
        read_text(tmp_path / "poses.csv")
