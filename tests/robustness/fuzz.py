"""Tries many spoilt inputs and writes what came of it: `make fuzz`.

Cases run in child processes, a block each, so that one that ends its process is a case that crashed.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from cases import LONG, QUICK, draw, seeds
from runner import run

from workbench.files.whole import put

ROOT = Path(__file__).resolve().parents[2]
BLOCK = 500
DRAWS = {"quick": QUICK, "long": LONG}
HEAD = """# What was tried to break it

Written by `make fuzz` (commit {commit}): {cases} spoilt inputs; `make test` tries 2,000. Each is a sound
campaign, robot, model, path or command line with one to three things spoilt at random
(`tests/robustness/mutators.py`):
cells, rows, columns, units and separators of tables; values, keys and sections of TOML; attributes and
elements of URDF; cut, empty, repeated and scrambled files; numbers that are none, not finite, or beyond all
measure; texts that would act in a terminal, a page or a program; arguments dropped, doubled, exchanged.
The command must answer (exit 0) or refuse (exit 2, a line for each fault), leave nothing behind when it
refuses, and never show a traceback or a warning of a library.

| what is spoilt: command | cases | exit 0 | exit 2 | exit 1 | crash | over 30 s | else wrong | slowest |
|---|---|---|---|---|---|---|---|---|
"""


def block(first: int, last: int, kind: str) -> None:
    """Runs some cases and prints one line of JSON for each."""
    with tempfile.TemporaryDirectory() as name:
        sound = seeds(Path(name) / "sound")
        for number in range(first, last):
            one = run(number, sound, DRAWS[kind], Path(name) / "case")
            facts = {"number": number, "kind": row(one.case), "status": one.status, "wrong": one.wrong}
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # MB
            print(json.dumps(facts | {"seconds": one.seconds, "memory": memory}), flush=True)


def row(case: Any) -> str:
    known = case.arguments[0] if case.arguments and case.kind != "command line" else ""
    return (
        f"{case.kind.split(',')[0]}: {known}{', to its end' if ',' in case.kind else ''}"
        if known
        else case.kind
    )


def outcomes(first: int, last: int, kind: str) -> Iterator[dict[str, Any]]:
    """The cases of a block from child processes: a child that dies takes one case with it."""
    while first < last:
        call = [sys.executable, __file__, "--block", str(first), str(last), "--kind", kind]
        done = subprocess.run(call, capture_output=True, text=True, check=False, cwd=ROOT)
        for line in done.stdout.splitlines():
            if line.startswith("{"):
                first += 1
                yield json.loads(line)
        if done.returncode:
            case = draw(first, defaultdict(lambda: "a\n"), DRAWS[kind])[0]
            wrong = f"process ended with {done.returncode}: {done.stderr[-300:]}"
            yield {
                "number": first,
                "kind": row(case),
                "status": "crash",
                "wrong": wrong,
                "seconds": 0.0,
                "memory": 0.0,
            }
            first += 1


def table(found: list[dict[str, Any]]) -> str:
    """The page."""
    kinds = defaultdict(list)
    for one in found:
        kinds[one["kind"]].append(one)
    lines = []
    for kind, cases in [*sorted(kinds.items()), ("**all**", found)]:
        status = [one["status"] for one in cases]
        counts = [status.count(name) for name in ("0", "2", "1", "crash", "hang")]
        other = sum(bool(one["wrong"]) for one in cases) - sum(counts[2:])
        slowest = max(one["seconds"] for one in cases)
        lines.append(
            f"| {kind} | {len(cases)} | {' | '.join(map(str, counts))} | {other} | {slowest:.1f} s |"
        )
    memory = max(one["memory"] for one in found)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    head = HEAD.format(cases=f"{len(found):,}", commit=commit.stdout.strip())
    return (
        head + "\n".join(lines) + f"\n\nPeak memory of a process that ran {BLOCK} of them: {memory:.0f} MB.\n"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=20_000)
    parser.add_argument(
        "--diagnosed", type=int, default=500, help="campaigns that are diagnosed to their end"
    )
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "robustness.md")
    parser.add_argument("--block", type=int, nargs=2)
    parser.add_argument("--case", type=int)
    parser.add_argument("--kind", choices=DRAWS, default="quick")
    arguments = parser.parse_args()
    if arguments.block:
        block(*arguments.block, arguments.kind)
        return 0
    if arguments.case is not None:
        with tempfile.TemporaryDirectory() as name:
            sound = seeds(Path(name) / "sound")
            print(run(arguments.case, sound, DRAWS[arguments.kind], Path(name) / "case"))
        return 0
    jobs = [("quick", n, arguments.cases) for n in range(0, arguments.cases, BLOCK)]
    jobs += [("long", n, arguments.diagnosed) for n in range(0, arguments.diagnosed, BLOCK // 5)]
    sizes = {"quick": BLOCK, "long": BLOCK // 5}
    found = []
    with ThreadPoolExecutor(arguments.workers) as pool:
        blocks = [
            pool.submit(lambda k, a, b: [*outcomes(a, b, k)], k, n, min(n + sizes[k], last))
            for k, n, last in jobs
        ]
        for one in blocks:
            found += one.result()
            print(
                f"… {len(found)} cases, {sum(bool(case['wrong']) for case in found)} wrong", file=sys.stderr
            )
    before = arguments.out.read_text(encoding="utf-8") if arguments.out.exists() else ""
    put(arguments.out, table(found) + "".join(before.partition("\n## ")[1:]))  # the first section is ours
    wrong = [case for case in found if case["wrong"]]
    for case in wrong:
        print(f"{case['kind']} {case['number']}: {case['wrong']}")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
