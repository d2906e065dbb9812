"""Tasks on several machines: those of a Dask scheduler (`dask scheduler`, and `dask worker ADDRESS` on each).

Every machine has the workbench installed. The scheduler gives the tasks of a worker that died to another; who
killed several is told as failed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import AbstractContextManager, contextmanager
from typing import TYPE_CHECKING

from ..files.faults import Fault, InputError

if TYPE_CHECKING:
    from distributed import Client

PATIENCE = "10s"  # until a scheduler that does not answer is told as such


def cluster_pool(scheduler: str) -> Callable[[int], AbstractContextManager[Executor]]:
    """What gives an executor on the scheduler at an address like "tcp://10.0.0.1:8786". Raises `InputError`
    where none answers, or Dask is not installed."""
    client = _client(scheduler)

    @contextmanager
    def pool(_: int) -> Iterator[Executor]:
        from distributed.cfexecutor import ClientExecutor

        executor: Executor = ClientExecutor(client, pure=False)
        try:
            yield executor
        finally:
            executor.shutdown(wait=False)
            client.close()

    return pool


def _client(scheduler: str) -> Client:
    try:
        from distributed import Client
    except ImportError:
        what, mend = "needs Dask, which is not installed", 'pip install "robot-workbench[cluster]"'
        raise InputError(Fault("--scheduler", what, mend)) from None
    try:
        return Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        what = f"no Dask scheduler answers at {scheduler!r} ({type(error).__name__})"
        mend = "start one with `dask scheduler`, and name the address that it tells"
        raise InputError(Fault("--scheduler", what, mend)) from error
