"""Cases of the blind study by their keys: `python -m workbench.studies.blind.one gear_ratio/3 [--seed 0]`."""

from __future__ import annotations

import argparse
import json
import os
import sys
from functools import partial
from pathlib import Path

from .blind_page import miss_cells
from .runner import one_thread_each, spawn_pool
from .score import run_case


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m workbench.studies.blind.one",
        description="One case of the blind study again: what was hidden, and what was said.",
    )
    parser.add_argument("keys", nargs="+", metavar="KEY", help="like gear_ratio/3, pair/0, clean-stated/2")
    parser.add_argument("--seed", type=int, default=0, help="of the study (0)")
    parser.add_argument("--short", action="store_true", help="one line per case")
    parser.add_argument("--report", type=Path, help="write the diagnosis' page and report under this folder")
    arguments = parser.parse_args()
    work = partial(run_case, seed=arguments.seed, report=arguments.report)
    with one_thread_each(), spawn_pool(min(len(arguments.keys), os.cpu_count() or 1)) as pool:
        for record in pool.map(work, arguments.keys):
            said = " | ".join(miss_cells(record)) if arguments.short else json.dumps(record, indent=1)
            print(said, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
