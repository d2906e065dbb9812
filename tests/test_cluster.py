"""Tasks on the workers of a Dask scheduler: one that is killed costs nothing."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future
from functools import partial
from pathlib import Path

import pytest
from test_tasks import note, runs

from workbench.cli.main import main
from workbench.files.faults import InputError
from workbench.studies.tasks import _result, run_tasks

pytest.importorskip("distributed")

STUDY = {"study": "test", "seed": 1}
CLUSTER = """
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    print(cluster.scheduler_address, flush=True)
    sys.stdin.read()
"""


def slow(key, folder):
    note(key, folder)
    (Path(folder) / f"{key}.pid").write_text(str(os.getpid()))
    time.sleep(0.3)
    return {"key": key}


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory):
    script = tmp_path_factory.mktemp("cluster") / "cluster.py"
    script.write_text(CLUSTER)
    here = os.pathsep.join([str(Path(__file__).parent), str(Path(__file__).parents[1])])
    running = subprocess.Popen(
        [sys.executable, str(script)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "PYTHONPATH": here, "OMP_NUM_THREADS": "1"},
    )
    assert running.stdout is not None
    yield running.stdout.readline().strip()
    running.communicate(timeout=60)


def test_a_worker_that_is_killed_costs_nothing(tmp_path, scheduler):
    keys, killed = [*(f"task{i}" for i in range(8)), "bad"], []

    def kill():
        until = time.monotonic() + 60
        while not killed and time.monotonic() < until:
            for file in tmp_path.glob("*.pid"):
                if text := file.read_text():
                    os.kill(int(text), signal.SIGKILL)
                    killed.append(file.stem)
                    return
            time.sleep(0.01)

    killer = threading.Thread(target=kill)
    killer.start()
    done = run_tasks(partial(slow, folder=str(tmp_path)), keys, tmp_path / "tasks.sqlite", study=STUDY,
                     scheduler=scheduler)  # fmt: skip
    killer.join()
    assert killed
    assert list(done) == keys
    assert "bad cannot be" in done["bad"].error
    assert [done[key].result for key in keys[:-1]] == [{"key": key} for key in keys[:-1]]
    assert runs(tmp_path, killed[0]) == 2
    again = run_tasks(partial(slow, folder=str(tmp_path)), keys, tmp_path / "tasks.sqlite", study=STUDY,
                      resume=True)  # fmt: skip
    assert [item.result for item in again.values()] == [item.result for item in done.values()]
    assert [runs(tmp_path, key) for key in (killed[0], "bad")] == [2, 2]


def test_what_the_workers_died_of_is_told():
    died, gone = Future(), Future()
    died.set_exception(RuntimeError("3 workers died of it"))
    gone.cancel()
    gone.set_running_or_notify_cancel()
    assert _result(died, "a").error == "RuntimeError: 3 workers died of it"
    with pytest.raises(InputError, match="go on with --resume"):
        _result(gone, "b")


def test_no_scheduler_is_told_in_a_line(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("workbench.studies.cluster.PATIENCE", "0.3s")
    call = ["study", "blind", "--quick", "--out", str(tmp_path), "--scheduler", "tcp://127.0.0.1:9"]
    assert main(call) == 2
    assert "no Dask scheduler answers at 'tcp://127.0.0.1:9'" in capsys.readouterr().err
    assert list(tmp_path.glob("*.json")) == []
