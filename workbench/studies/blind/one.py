"""Cases of the blind study again, by their keys."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from ...files.faults import Fault, InputError
from ...simulation.processes import one_thread_each, spawn_pool
from ..case_study import Record
from . import case_keys
from .score import run_case


def cases_again(keys: Sequence[str], seed: int, report: Path | None, workers: int | None) -> Iterator[Record]:
    """The records of some cases of the study with this seed, in the order of the keys, as they come.

    report: folder under which each diagnosis' page is written; workers: processes, None: one a core. Raises
    InputError where there is no such case.
    """
    kinds = sorted({key.partition("/")[0] for key in case_keys(1)})
    faults = []
    for key in keys:
        kind, _, number = key.partition("/")
        if kind not in kinds or not number.isdecimal():
            faults.append(Fault(key, "is no case", f"like gear_ratio/3; known: {', '.join(kinds)}"))
    if faults:
        raise InputError(faults)
    work = partial(run_case, seed=seed, report=report)
    with one_thread_each(), spawn_pool(min(len(keys), workers or os.cpu_count() or 1)) as pool:
        yield from pool.map(work, keys)
