"""A study of many cases: a task each, counted when all are done."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from .tasks import run_tasks

Record = dict[str, Any]


@dataclass(frozen=True)
class CaseStudy(ABC):
    """A finished study: its cases and what they come to. failed: key → error of cases that broke."""

    folder: Path
    seed: int
    cases: tuple[Record, ...]
    failed: dict[str, str]

    @abstractmethod
    def to_json(self) -> dict[str, Any]:
        """What the cases come to."""

    @property
    def broken(self) -> list[str]:
        """A line for each case that broke."""
        return [f"FAILED {key}: {error.strip().splitlines()[-1]}" for key, error in self.failed.items()]

    @property
    def results(self) -> bytes:
        """The content of `results.json`: what the cases come to, and every case."""
        everything = {**self.to_json(), "results": self.cases}
        return json.dumps(everything, ensure_ascii=False, indent=1).encode()


Counted = TypeVar("Counted", bound=CaseStudy)


def run_cases(
    study: type[Counted],
    name: str,
    work: Callable[..., Record],
    keys: Sequence[str],
    out: Path,
    seed: int,
    workers: int | None,
    resume: bool,
    scheduler: str | None = None,
) -> Counted:
    """The study of these cases, kept in `<name>.sqlite`; work(key, seed=seed) is a case's record."""
    done = run_tasks(
        partial(work, seed=seed),
        keys,
        out / f"{name}.sqlite",
        study={"study": name, "seed": seed},
        workers=workers,
        resume=resume,
        label=name,
        scheduler=scheduler,
    )
    failed = {key: item.error for key, item in done.items() if item.error is not None}
    return study(out, seed, tuple(item.result for item in done.values() if item.error is None), failed)
