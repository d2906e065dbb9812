"""Wall time of a job on a machine that does other things too."""

from __future__ import annotations

import time
from collections.abc import Callable


def shortest(job: Callable[[], object], runs: int = 5) -> float:
    """The shortest of some runs [s]."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        job()
        times.append(time.perf_counter() - start)
    return min(times)
