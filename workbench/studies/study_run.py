"""One run of a study: where it writes, its seed, how much it draws, on how many processes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


def silent(_: str) -> None:
    """Says nothing."""


@dataclass(frozen=True)
class StudyRun:
    """What a study's script gets.

    folder: for its results; quick: few draws; workers: processes, all cores by default; resume: take what a
    stopped run drew; say: what is being done, for people; measured: folder of measured campaigns, for the
    question of each study on a measured robot; drawn: folder for what is drawn, by default in that of the
    results.
    """

    folder: Path
    seed: int = 0
    quick: bool = False
    workers: int | None = None
    resume: bool = False
    say: Callable[[str], None] = silent
    measured: Path | None = None
    drawn: Path | None = None

    def draws(self, full: int, quick: int) -> int:
        """How many draws: `full`, or `quick` in a quick run."""
        return quick if self.quick else full

    def store(self, name: str) -> Path:
        """The file that keeps what was drawn under this name."""
        return (self.drawn or self.folder / "draws") / f"{name}.sqlite"
