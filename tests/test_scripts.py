"""Processes of one's own: a study's script, a source tree, a run that is interrupted."""

import os
import shutil
import signal
import subprocess
import sys
import time
import types
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


SCRIPT = '''"""A study of my own."""

from workbench import Fault, InputError, run_study


def study(run):
    run.say(f"{run.drawn} {run.seed} {run.quick} {run.workers} {run.resume}")
    if run.seed == 1:
        raise KeyboardInterrupt
    if run.seed == 2:
        raise InputError(Fault("my.toml", "is not there"))
    raise ArithmeticError("no")


run_study(study)
'''


@pytest.mark.parametrize(
    ("given", "status", "said"),
    [
        (["--help"], 0, "A study of my own."),
        (["--quick"], 1, "… reports/mine/draws 0 True None False\nfailed: ArithmeticError: no"),
        (
            ["--seed", "1", "--out", "here", "--workers", "3"],
            130,
            "… here/draws 1 False 3 False\ninterrupted\n",
        ),
        (["--seed", "2"], 2, "error: my.toml: is not there"),
        (["--resume"], 1, "… reports/mine/draws 0 False None True\n"),
        (["--draws", "3"], 2, "unrecognized arguments: --draws"),
        (["--out", "taken"], 2, "is a file, not a folder"),
    ],
)
def test_a_script_of_one_s_own_ends_as_a_command_does(tmp_path, monkeypatch, capsys, given, status, said):
    mine(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["mine/study.py", *given])
    monkeypatch.setitem(sys.modules, "__main__", sys.modules["__main__"])  # which becomes the script
    with pytest.raises(SystemExit) as ended:
        as_main(tmp_path / "mine/study.py")
    assert ended.value.code == status
    assert said in "".join(capsys.readouterr())


def mine(folder):
    """A script of one's own in the folder, and a file."""
    (folder / "mine").mkdir()
    (folder / "mine/study.py").write_text(SCRIPT)
    (folder / "taken").write_text("mine")


def as_main(path):
    """Runs a script here as `python` does: its module stays the main one, which `run_study` asks for."""
    sys.modules["__main__"] = module = types.ModuleType("__main__")
    module.__file__ = str(path)
    exec(compile(path.read_text(), path, "exec"), vars(module))


def test_a_script_that_is_interrupted_ends_its_process_with_130(tmp_path):
    mine(tmp_path)
    done = subprocess.run(
        [sys.executable, "mine/study.py", "--seed", "1", "--out", "here", "--workers", "3"],
        capture_output=True,
        text=True,
        timeout=120,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 130, done.stderr
    assert "… here/draws 1 False 3 False\ninterrupted\n" in done.stderr


def test_the_version_of_a_source_tree_is_what_it_says(tmp_path):
    for part in ("__init__.py", "__main__.py", "cli", "files", "studies/__init__.py"):
        source, copy = ROOT / "workbench" / part, tmp_path / "workbench" / part
        copy.parent.mkdir(exist_ok=True)
        (shutil.copytree if source.is_dir() else shutil.copy)(source, copy)
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "robot-workbench"\nversion = "7.8.9"\n')
    # -S: without the place where an installed distribution is
    command = [sys.executable, "-S", "-m", "workbench", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert (done.stdout, done.returncode) == ("workbench 7.8.9\n", 0), done.stderr


SLEEPY = """
import signal, sys, time
from pathlib import Path
from workbench.cli.status import guarded
from workbench.studies.tasks import run_tasks

def work(key):
    Path(f"{key}.started").touch()
    time.sleep(60)

if __name__ == "__main__":
    signal.signal(signal.SIGINT, getattr(signal, sys.argv[1]))  # not as whoever runs the tests was started
    sys.exit(guarded(lambda: run_tasks(work, ["a", "b", "c"], Path("tasks.sqlite"), study={}, workers=2)))
"""


@pytest.mark.parametrize(
    ("number", "everyone", "at_start", "status", "line"),
    [
        (signal.SIGINT, False, "default_int_handler", 130, "interrupted\n"),
        (signal.SIGINT, True, "default_int_handler", 130, "interrupted\n"),
        (signal.SIGTERM, False, "default_int_handler", 143, "terminated\n"),
        (signal.SIGTERM, False, "SIG_IGN", 143, "terminated\n"),
    ],
)
def test_ctrl_c_and_sigterm_end_workers_too(tmp_path, number, everyone, at_start, status, line):
    """As `kill` tells the one process, and as a terminal tells all of them; also where a shell started it in
    the background, with Ctrl-C ignored."""
    (tmp_path / "sleepy.py").write_text(SLEEPY)
    running = subprocess.Popen(
        [sys.executable, "sleepy.py", at_start],
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        start_new_session=True,
    )
    until = time.monotonic() + 60
    while len(list(tmp_path.glob("*.started"))) < 2 and time.monotonic() < until:
        time.sleep(0.05)
    (os.killpg if everyone else os.kill)(running.pid, number)
    said = running.communicate(timeout=30)[1]
    assert (said, running.returncode) == (line, status)
