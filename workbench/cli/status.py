"""How a command ends, and what it says on the way: exit status and standard error."""

from __future__ import annotations

import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ..files.faults import InputError

DONE, FAILED, WRONG, INTERRUPTED = 0, 1, 2, 130


def guarded(action: Callable[[], int | None]) -> int:
    """Exit status of an action: its own, or 0 where it has none; 2 the input or the call is wrong (a line per
    fault), 1 it failed, 130 interrupted."""
    for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(threads, "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without µ is no reason to fail
    try:
        with _workers_stop_too():
            status = action()
    except InputError as error:
        for fault in error.faults:
            print(f"error: {fault}", file=sys.stderr)
        return WRONG
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except Exception as error:
        if os.environ.get("WORKBENCH_DEBUG"):
            raise
        print(f"failed: {type(error).__name__}: {error} (WORKBENCH_DEBUG=1 shows where)", file=sys.stderr)
        return FAILED
    else:
        return DONE if status is None else status
    return DONE


def progress(message: str) -> None:
    """What is being done, beside the result."""
    print(f"… {message}", file=sys.stderr, flush=True)


@contextmanager
def _workers_stop_too() -> Iterator[None]:
    """Ctrl-C in here stops worker processes as well: a pool would wait for the tasks that they are at."""
    usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not usual or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, _stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _stop(*_: Any) -> None:
    from multiprocessing import active_children

    for worker in active_children():
        worker.terminate()
    raise KeyboardInterrupt
