"""How a command ends, and what it says on the way: exit status and standard error."""

from __future__ import annotations

import gc
import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ..files.faults import InputError, plain

DONE, FAILED, WRONG, INTERRUPTED, TERMINATED = 0, 1, 2, 130, 143


class Terminated(BaseException):
    """The process was asked to end (SIGTERM)."""


@contextmanager
def loading() -> Iterator[None]:
    """While the modules of a command are loaded nobody looks for garbage among them, nor later: there is
    none, and to look takes a tenth of a second, and again in the midst of the work."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def guarded(action: Callable[[], int | None]) -> int:
    """Exit status of an action: its own, or 0 where it has none; 2 the input or the call is wrong (a line per
    fault), 1 it failed, 130 interrupted, 143 terminated."""
    for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[threads] = "1"  # sums in one order: the same bytes out, however many cores there are
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without µ is no reason to fail
    status: int | None = None
    try:
        with _workers_stop_too():
            status = action()
    except InputError as error:
        for fault in error.faults:
            print(f"error: {plain(str(fault))}", file=sys.stderr)
        return WRONG
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except Terminated:
        print("terminated", file=sys.stderr)
        return TERMINATED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:  # a full disk, a folder that nobody may write in
        if os.environ.get("WORKBENCH_DEBUG"):
            raise
        where, what = plain(str(error.filename or "writing")), error.strerror or type(error).__name__
        print(f"error: {where}: {what}; make room, or name another place with --out", file=sys.stderr)
        return WRONG
    except SystemExit as error:
        if not isinstance(error.code, str):
            raise
        if os.environ.get("WORKBENCH_DEBUG"):
            raise AssertionError(error.code) from error  # Python ends on the other without a word of where
        return _failed(error)  # Drake's assertions
    except Exception as error:
        if os.environ.get("WORKBENCH_DEBUG"):
            raise
        return _failed(error)
    return DONE if status is None else status


def _failed(error: BaseException) -> int:
    what = plain(str(error))
    print(f"failed: {type(error).__name__}: {what} (WORKBENCH_DEBUG=1 shows where)", file=sys.stderr)
    return FAILED


def progress(message: str) -> None:
    """What is being done, beside the result."""
    print(f"… {message}", file=sys.stderr, flush=True)


def warn(message: str) -> None:
    """What changes how a result is to be read, beside it."""
    print(f"warning: {plain(message)}", file=sys.stderr, flush=True)


@contextmanager
def _workers_stop_too() -> Iterator[None]:
    """Ctrl-C and SIGTERM in here stop worker processes as well: a pool would wait for the tasks that they are
    at."""
    usual: dict[int, Any] = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
    here = threading.current_thread() is threading.main_thread()
    # each for itself: a shell lets what it starts in the background ignore Ctrl-C, not SIGTERM
    ours = {
        number: handler for number, handler in usual.items() if here and signal.getsignal(number) is handler
    }
    for number in ours:
        signal.signal(number, _stop)
    try:
        yield
    finally:
        for number, handler in ours.items():
            signal.signal(number, handler)


def _stop(number: int, *_: Any) -> None:
    from multiprocessing import active_children

    for worker in active_children():
        worker.kill()  # a worker that is only asked to end may be inside of what nobody interrupts
    raise KeyboardInterrupt if number == signal.SIGINT else Terminated
