"""Runs studies: one script each, its results in one folder each."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from pathlib import Path

from ..files.whole import put
from ..report.study import Study
from ..report.study_page import index, write_study

Progress = Callable[[str], None]
Script = Callable[[Path, int, bool, Progress], Study]


def run(script: Script, folder: Path, seed: int, quick: bool, say: Progress) -> Study:
    """Runs a study's script and writes its page, PDF, scene and numbers into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    found = script(folder, seed, quick, say)
    say("writing the page, the report and the scene")
    write_study(found, folder)
    return found


def run_published(names: Sequence[str], folder: Path, seed: int, quick: bool, say: Progress) -> list[Study]:
    """Runs studies by name: a single one into `folder`, several into folders of their names there,
    with a list of them in `index.html`."""
    found = []
    for name in names:
        script: Script = importlib.import_module(f"workbench.studies.{name}.study").study
        if len(names) == 1:
            return [run(script, folder, seed, quick, say)]
        say(f"study {name}")
        found.append(run(script, folder / name, seed, quick, say))
    put(folder / "index.html", index(found).encode())
    return found
