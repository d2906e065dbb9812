"""Independent work on all cores: forked processes, which see all that is in memory without a copy."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from typing import Any, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

_work: tuple[Callable[[Any], Any], Sequence[Any]] | None = None  # what forks find to do


def side_by_side(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """What the work makes of each item. In this process where it has but one core or cannot fork, or is
    itself one of several at work."""
    with begun(work, items) as done:
        return done()


@contextmanager
def begun(work: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Callable[[], list[Result]]]:
    """The work of each item, begun on all cores while this process goes on; what it gives waits for what came
    of it. Done here, when it is asked for, where `side_by_side` does it here."""
    global _work
    count = min(cores(), len(items))
    if count < 2 or parent_process() is not None:
        yield lambda: [work(item) for item in items]
        return
    leave_ctrl_c = (signal.SIGINT, signal.SIG_IGN)  # to who started them
    pool = ProcessPoolExecutor(count, get_context("fork"), signal.signal, leave_ctrl_c)
    try:
        _work = work, items
        found = [pool.submit(_done, i) for i in range(len(items))]  # the first forks them all
        _work = None
        yield lambda: [one.result() for one in found]
    finally:
        _work = None
        pool.shutdown(cancel_futures=True)


def cores() -> int:
    """Those that this process may use; one where a process cannot fork."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else 1


def _done(i: int) -> Any:
    assert _work is not None, "not a fork"
    work, items = _work
    return work(items[i])
