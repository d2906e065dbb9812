"""Processes for many tasks at a time: fresh ones, one BLAS thread each, Ctrl-C left to who started them."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def spawn_pool(workers: int) -> Executor:
    """Processes that start fresh, and leave Ctrl-C to the one that started them."""
    spawn = get_context("spawn")
    return ProcessPoolExecutor(workers, spawn, signal.signal, (signal.SIGINT, signal.SIG_IGN))


_kept: dict[int, Executor] | None = None  # by their number, while pools are kept


@contextmanager
def pools_kept() -> Iterator[None]:
    """Processes that are borrowed in here stay for who borrows next: to start them takes seconds."""
    global _kept
    if _kept is not None:
        yield
        return
    _kept = {}
    try:
        yield
    finally:
        every, _kept = _kept, None
        for executor in every.values():
            executor.shutdown(wait=False, cancel_futures=True)


@contextmanager
def borrowed_pool(workers: int) -> Iterator[Executor]:
    """Processes that start fresh, or were kept. After an error they end, and what waits is not begun."""
    executor = None if _kept is None else _kept.pop(workers, None)
    executor = executor or spawn_pool(workers)
    sound = False
    try:
        yield executor
        sound = True
    finally:
        if sound and _kept is not None:
            _kept[workers] = executor
        else:
            executor.shutdown(wait=False, cancel_futures=True)


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Processes that start in here use one BLAS thread each."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
