"""Many tasks: each result kept, stopped runs resumed, dead workers replaced."""

import os
import sqlite3
from functools import partial
from pathlib import Path

import pytest

from workbench.files.faults import InputError
from workbench.simulation.processes import pools_kept
from workbench.studies.tasks import run_tasks

STUDY = {"study": "test", "seed": 1}


def note(key, folder):
    """Leaves a mark that it ran; breaks, or dies, where the key says so."""
    with (Path(folder) / key).open("a") as file:
        file.write("x")
    if key.startswith("bad"):
        raise ValueError(f"{key} cannot be")
    if key.startswith("deadly") and len((Path(folder) / key).read_text()) <= int(key[-1]):
        os._exit(9)
    return {"key": key, "threads": os.environ.get("OMP_NUM_THREADS")}


def runs(folder, key):
    mark = folder / key
    return len(mark.read_text()) if mark.exists() else 0


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_in_the_order_of_the_keys_and_errors_with_them(tmp_path, workers):
    work = partial(note, folder=str(tmp_path))
    keys = ["d", "bad", "a", "c"]
    done = run_tasks(work, keys, tmp_path / "tasks.sqlite", study=STUDY, workers=workers)
    assert list(done) == keys
    assert [item.result["key"] for item in done.values() if item.error is None] == ["d", "a", "c"]
    assert "ValueError: bad cannot be" in done["bad"].error
    assert all(item.result["threads"] == "1" for item in done.values() if item.error is None)


def test_a_resumed_run_does_only_what_is_missing(tmp_path):
    work, store = partial(note, folder=str(tmp_path)), tmp_path / "tasks.sqlite"
    run_tasks(work, ["a", "bad"], store, study=STUDY, workers=1)
    done = run_tasks(work, ["a", "bad", "b"], store, study=STUDY, workers=1, resume=True)
    assert [runs(tmp_path, key) for key in ("a", "bad", "b")] == [1, 2, 1]
    assert done["a"].result["key"] == "a"
    run_tasks(work, ["a"], store, study=STUDY, workers=1)
    assert runs(tmp_path, "a") == 2


def test_a_stopped_run_has_kept_what_it_did(tmp_path):
    def stopped(key):
        if key == "c":
            raise KeyboardInterrupt
        return key.upper()

    store = tmp_path / "tasks.sqlite"
    with pytest.raises(KeyboardInterrupt):
        run_tasks(stopped, ["a", "b", "c"], store, study=STUDY, workers=1)
    table = sqlite3.connect(store)
    assert [row[0] for row in table.execute("SELECT key FROM tasks ORDER BY key")] == ["a", "b"]
    assert table.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    table.close()
    done = run_tasks(str.lower, ["a", "b", "c"], store, study=STUDY, workers=1, resume=True)
    assert [item.result for item in done.values()] == ["A", "B", "c"]


def test_another_study_s_file_is_not_resumed(tmp_path):
    store = tmp_path / "tasks.sqlite"
    run_tasks(str.upper, ["a"], store, study=STUDY, workers=1)
    with pytest.raises(InputError, match="holds another study"):
        run_tasks(str.upper, ["a"], store, study={**STUDY, "seed": 2}, workers=1, resume=True)


def test_a_dead_worker_costs_nothing_but_its_own_task(tmp_path):
    work = partial(note, folder=str(tmp_path))
    keys = ["a", "b", "deadly1", "deadly9", "c", "d", "e", "f"]
    done = run_tasks(work, keys, tmp_path / "tasks.sqlite", study=STUDY, workers=2)
    assert done["deadly9"].error == "its worker died 3 times"
    assert all(done[key].error is None for key in keys if key != "deadly9")


def test_progress_is_told_in_plain_lines(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("workbench.studies.tasks.LINE_EVERY", 0.0)
    run_tasks(str.upper, ["a", "b"], tmp_path / "tasks.sqlite", study=STUDY, workers=1, label="two")
    said = capsys.readouterr()
    assert said.out == ""
    assert "… two: 1 of 2" in said.err
    assert "min left" in said.err


def pid(key):
    return os.getpid()


def test_kept_processes_serve_the_next_tasks_and_dead_ones_are_replaced(tmp_path):
    def asked(work, keys, name):
        done = run_tasks(work, keys, tmp_path / name, study=STUDY, workers=2)
        assert not [item.error for item in done.values() if item.error]
        return {item.result for item in done.values()}

    with pools_kept():
        first = asked(pid, list("abcdefgh"), "1.sqlite")
        with pools_kept():
            first |= asked(pid, list("ijklmnop"), "2.sqlite")
        assert len(first | asked(pid, list("abcdefgh"), "3.sqlite")) <= 2
        run_tasks(
            partial(note, folder=str(tmp_path)), ["deadly-1", "x"], tmp_path / "4", study=STUDY, workers=2
        )
        assert asked(pid, list("abcdefgh"), "5.sqlite").isdisjoint(first)
    assert asked(pid, list("abcdefgh"), "6.sqlite").isdisjoint(first)
