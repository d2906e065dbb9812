"""Tasks on several machines: those of a Dask scheduler (`dask scheduler`, and `dask worker ADDRESS` on each).

Every machine has the workbench installed. The scheduler gives the tasks of a worker that died to another; who
killed several is told as failed.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from typing import TYPE_CHECKING

from ..files.faults import Fault, InputError

if TYPE_CHECKING:
    from distributed import Client

PATIENCE = "10s"  # until a scheduler that does not answer is told as such


def cluster_pool(scheduler: str) -> Callable[[int], Executor]:
    """What makes an executor on the scheduler at an address like "tcp://10.0.0.1:8786". Raises `InputError`
    where none answers, or Dask is not installed."""
    client = _client(scheduler)

    def pool(_: int) -> Executor:
        from distributed.cfexecutor import ClientExecutor

        class OfClient(ClientExecutor):
            def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
                super().shutdown(wait and not cancel_futures)
                client.close()

        executor: Executor = OfClient(client, pure=False)
        return executor

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
