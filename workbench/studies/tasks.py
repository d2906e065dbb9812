"""Runs many tasks on all cores, keeps each result as it comes, and goes on where a stopped run ended.

A task is a key; `work` turns a key into a result that JSON can hold. Everything random in it comes
from the key, so the order of tasks and the number of processes change nothing. One SQLite file per
study holds a row per finished task. A pool that breaks (a worker was killed) is built again; tasks
that were in it are tried again, each at most `TRIES` times.
"""

from __future__ import annotations

import gc
import json
import os
import sqlite3
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..files.faults import Fault, InputError
from ..simulation.processes import borrowed_pool, one_thread_each
from .cluster import cluster_pool

TRIES = 3
LINE_EVERY = 15.0  # s between progress lines where there is no terminal
Work = Callable[[str], Any]
Pool = Callable[[int], AbstractContextManager[Executor]]


@dataclass(frozen=True)
class Done:
    """A finished task: its result, or what went wrong (the last lines of the traceback)."""

    key: str
    result: Any
    error: str | None
    seconds: float


def run_tasks(
    work: Work,
    keys: Sequence[str],
    store: Path,
    *,
    study: Mapping[str, Any],
    workers: int | None = None,
    resume: bool = False,
    label: str = "tasks",
    scheduler: str | None = None,
) -> dict[str, Done]:
    """All tasks' results by key, in the order of `keys`.

    study: what the results depend on besides the key (seed, ...): a file of another study is not
    resumed. Without `resume` the file starts anew. Failed tasks are kept with their error, and tried
    again by the next run. workers: processes, all cores by default; 1: in this process. scheduler: address
    of a Dask scheduler, whose workers do it instead.
    """
    gc.collect()  # what is left of Drake's objects ends here: in the thread of a pool it ends the process
    pool: Pool = borrowed_pool if scheduler is None else cluster_pool(scheduler)
    with _faults_of(store), closing(_open(store, study, resume)) as table:
        have = _read(table)
        todo = [key for key in dict.fromkeys(keys) if key not in have or have[key].error is not None]
        most = (workers or os.cpu_count() or 1) if scheduler is None else len(todo)
        count, here = max(1, min(most, len(todo))), scheduler is None and min(most, len(todo)) < 2
        with one_thread_each(), _Progress(label, len(keys), len(keys) - len(todo)) as progress:
            done = _here(work, todo) if here else _there(work, todo, pool, count)
            for item in done:
                _write(table, item)
                have[item.key] = item
                progress.step(item)
    return {key: have[key] for key in keys}


@contextmanager
def _faults_of(store: Path) -> Iterator[None]:
    """What SQLite cannot do with its file (a full disk, no right to write there) as an input error."""
    try:
        yield
    except sqlite3.DatabaseError as error:
        mend = "make room, or name another place with --out; what is done is kept for --resume"
        raise InputError(Fault(str(store), f"{error}", mend)) from error


def _attempt(work: Work, key: str) -> Done:
    start = time.perf_counter()
    try:
        result, error = work(key), None
    except Exception:
        result, error = None, traceback.format_exc(limit=-6)
    return Done(key, result, error, time.perf_counter() - start)


def _here(work: Work, keys: Sequence[str]) -> Iterator[Done]:
    for key in keys:
        yield _attempt(work, key)


def _there(work: Work, keys: Sequence[str], pool: Pool, workers: int) -> Iterator[Done]:
    """Results as they come. Few tasks are in the pool at a time, so few are lost when it breaks."""
    waiting = deque(keys)
    tries: dict[str, int] = {}
    while waiting:
        running: dict[Future[Done], str] = {}
        try:
            with pool(workers) as executor:
                while waiting or running:
                    # after a breakdown one at a time, so that the task that kills its worker is found
                    room = 1 if any(tries.get(key) for key in waiting) else 2 * workers
                    while waiting and len(running) < room:
                        running[executor.submit(_attempt, work, waiting[0])] = waiting[0]
                        waiting.popleft()  # only now: a broken pool takes nothing
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        done = _result(future, running[future])
                        del running[future]
                        yield done
        except BrokenProcessPool:
            for future, key in running.items():
                if future.done() and future.exception() is None:
                    yield future.result()
                    continue
                tries[key] = tries.get(key, 0) + 1
                if tries[key] < TRIES:
                    waiting.appendleft(key)
                else:
                    yield Done(key, None, f"its worker died {TRIES} times", 0.0)


def _result(future: Future[Done], key: str) -> Done:
    """What came of a task; where a cluster's workers died of it, that."""
    try:
        error = future.exception()
    except CancelledError as gone:
        mend = "what is done is kept: start it again, and go on with --resume"
        raise InputError(Fault("--scheduler", "it is gone", mend)) from gone
    if error is None or isinstance(error, BrokenProcessPool):
        return future.result()
    return Done(key, None, f"{type(error).__name__}: {error}", 0.0)


def _open(store: Path, study: Mapping[str, Any], resume: bool) -> sqlite3.Connection:
    store.parent.mkdir(parents=True, exist_ok=True)
    table = sqlite3.connect(store)
    table.execute("PRAGMA journal_mode=WAL")
    table.execute("CREATE TABLE IF NOT EXISTS study (facts TEXT)")
    table.execute(
        "CREATE TABLE IF NOT EXISTS tasks (key TEXT PRIMARY KEY, result TEXT, error TEXT, seconds REAL)"
    )
    facts = json.dumps(dict(study), sort_keys=True)
    was = table.execute("SELECT facts FROM study").fetchone()
    if resume and was is not None and was[0] != facts:
        table.close()
        raise InputError(Fault(str(store), f"holds another study: {was[0]}", "leave out --resume"))
    if not resume or was is None:
        table.execute("DELETE FROM tasks")
        table.execute("DELETE FROM study")
        table.execute("INSERT INTO study VALUES (?)", (facts,))
    table.commit()
    return table


def _read(table: sqlite3.Connection) -> dict[str, Done]:
    rows = table.execute("SELECT key, result, error, seconds FROM tasks")
    return {key: Done(key, json.loads(result), error, seconds) for key, result, error, seconds in rows}


def _write(table: sqlite3.Connection, done: Done) -> None:
    row = (done.key, json.dumps(done.result), done.error, done.seconds)
    table.execute("INSERT OR REPLACE INTO tasks VALUES (?, ?, ?, ?)", row)
    table.commit()


@dataclass
class _Progress:
    """A bar on a terminal; elsewhere a line now and then, with the time that is left."""

    label: str
    total: int
    before: int
    start: float = field(default_factory=time.monotonic)
    done: int = 0
    failed: int = 0
    said: float = field(default_factory=time.monotonic)
    bar: Any = None

    def __enter__(self) -> _Progress:
        if sys.stderr.isatty():
            from tqdm import tqdm

            self.bar = tqdm(total=self.total, initial=self.before, desc=self.label, unit="task")
        elif self.before:
            self._say(f"{self.before} of {self.total} done before")
        return self

    def step(self, done: Done) -> None:
        self.done += 1
        self.failed += done.error is not None
        if self.bar is not None:
            self.bar.update()
            if self.failed:
                self.bar.set_postfix(failed=self.failed)
        elif time.monotonic() - self.said > LINE_EVERY:
            self.said = time.monotonic()
            each = (self.said - self.start) / self.done
            left = each * (self.total - self.before - self.done)
            failed = f", {self.failed} failed" if self.failed else ""
            at = self.before + self.done
            self._say(f"{at} of {self.total}{failed}, {each:.1f} s each, {left / 60:.0f} min left")

    def _say(self, text: str) -> None:
        print(f"… {self.label}: {text}", file=sys.stderr, flush=True)

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()
