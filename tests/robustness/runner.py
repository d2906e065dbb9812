"""Runs spoilt cases in this process, each in a folder of its own, and says how each ended."""

from __future__ import annotations

import io
import os
import re
import shutil
import signal
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

from cases import Case, Draw, draw

from workbench.cli import main as command
from workbench.files.faults import CONTROL

PARSER = cache(command.command_line)  # makes hundreds of options every time
LONGEST = 30  # s of a processor for a case, from which it hangs: others may be busy on the machine,
WAITING = 600  # s, in which it got none of it
RAW = re.compile(r"Traceback|Warning:|bazel|pydantic|numpy\.|Error:|SVD did|Eigenvalue|infs or NaNs")


@dataclass(frozen=True)
class Ended:
    """number, case; status: exit status, "hang" or "crash"; wrong: what must not be, "" when all is well."""

    number: int
    case: Case
    status: str
    wrong: str
    seconds: float
    said: str


class Hang(BaseException):
    """A case took too long."""


def run(number: int, sound: dict[str, str], draws: list[tuple[int, Draw]], folder: Path) -> Ended:
    """One case from its number."""
    case, files = draw(number, sound, draws)
    return run_case(number, case, files, folder)


def run_case(number: int, case: Case, files: dict[str, str], folder: Path) -> Ended:
    """One case, with these files in its folder."""
    place = _empty(folder)
    for name, text in files.items():
        (place / name).write_bytes(text.encode("utf-8", "surrogatepass"))
    before, here = set(os.listdir(place)), os.getcwd()
    out, err = io.StringIO(), io.StringIO()
    start = time.process_time()
    os.chdir(place)
    try:
        with (
            redirect_stdout(out),
            redirect_stderr(err),
            patch.object(command, "command_line", PARSER),
            _limited(),
        ):
            status = str(command.main(case.arguments))
    except SystemExit as ended:
        status = str(ended.code)
    except Hang:
        status = "hang"
    except BaseException:
        status = "crash"
        err.write(traceback.format_exc())
    finally:
        os.chdir(here)
    seconds = time.process_time() - start
    new = set(os.listdir(place)) - before
    said = err.getvalue()
    return Ended(number, case, status, _wrong(status, said, out.getvalue(), new), seconds, said)


def _empty(folder: Path) -> Path:
    """The folder with nothing in it: making and removing folders takes longer than most cases."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in folder.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    return folder


def _wrong(status: str, said: str, out: str, new: set[str]) -> str:
    if status not in ("0", "2"):
        return f"exit {status}"
    if raw := RAW.search(said):
        return f"raw {raw[0]!r}"
    if status == "2" and not re.search(r"^error: |^usage: ", said, re.MULTILINE):
        return "exit 2 without a word"
    if status == "2" and new:
        return f"left behind: {sorted(new)}"
    if CONTROL.search(said + out) or max(map(len, said.splitlines()), default=0) > 12_000:
        return "control characters or endless lines"
    return ""


@contextmanager
def _limited() -> Iterator[None]:
    def stop(*_: Any) -> None:
        raise Hang

    timers = {signal.ITIMER_PROF: (signal.SIGPROF, LONGEST), signal.ITIMER_REAL: (signal.SIGALRM, WAITING)}
    usual = {number: signal.signal(number, stop) for number, _ in timers.values()}
    for timer, (_, longest) in timers.items():
        signal.setitimer(timer, longest)
    try:
        yield
    finally:
        for timer, (number, _) in timers.items():
            signal.setitimer(timer, 0)
            signal.signal(number, usual[number])
