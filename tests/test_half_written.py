"""Killed, full, forbidden, two at once: the result folder is the old one or the new one."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from pathlib import Path

import pytest

from workbench.campaign import load_campaign
from workbench.cli.main import main
from workbench.files.faults import InputError, read_text
from workbench.files.whole import put, put_all

ROOT = Path(__file__).resolve().parents[1]
NAMES = ("poses.csv", "points.csv", "deep/picture.svg", "campaign.toml")
SIMULATE = ("simulate", "cylindrical", "--random", "12", "--out")

# writes one generation of a result after the other, without end
WRITER = """
import sys
from itertools import count
from pathlib import Path
from workbench.files.whole import put_all
folder, who = Path(sys.argv[1]), sys.argv[2]
for generation in count():
    put_all({folder / name: f"{who}{generation}\\n" * 3000 for name in sys.argv[3:]})
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


def writer(folder: Path, who: str) -> subprocess.Popen[bytes]:
    (folder.parent / f"{who}.started").unlink(missing_ok=True)
    command = [sys.executable, "-c", WRITER, str(folder), who, *NAMES]
    return subprocess.Popen(command, env={**os.environ, "PYTHONPATH": str(ROOT)})


def wait_for(*files: Path) -> None:
    until = time.monotonic() + 60
    while not all(file.exists() for file in files) and time.monotonic() < until:
        time.sleep(0.005)


@pytest.mark.parametrize("seed", range(6))
def test_killed_at_any_time(tmp_path: Path, seed: int) -> None:
    running = writer(tmp_path / "out", "a")
    wait_for(tmp_path / "a.started")
    time.sleep(random.Random(seed).uniform(0, 0.02))
    running.kill()
    running.wait()
    assert whole(tmp_path / "out").startswith("a")


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


def test_two_runs_into_one_folder(tmp_path: Path) -> None:
    both = [writer(tmp_path / "out", who) for who in "ab"]
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
