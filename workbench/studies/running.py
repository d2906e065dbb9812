"""Runs studies: one script each, its results in one folder each."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import replace

from ..files.whole import gathered, put
from ..report.study import Study
from ..report.study_page import index, write_study
from ..simulation.processes import pools_kept
from .study_run import StudyRun

Script = Callable[[StudyRun], Study]


def run_script(script: Script, run: StudyRun) -> Study:
    """Runs a study's script, which writes into the run's folder, and writes its page, PDF, scene and numbers
    there: all files of both in the end, or none. What is drawn is kept at once, for a run that resumes."""
    with pools_kept(), gathered(run.folder) as made:
        found = script(replace(run, folder=made, drawn=run.folder / "draws"))
        run.say("writing the page, the report and the scene")
        write_study(found, made)
    return found


def run_published(names: Sequence[str], run: StudyRun) -> list[Study]:
    """Runs studies by name: a single one into the run's folder, several into folders of their names there,
    with a list of them in `index.html`."""
    found = []
    with pools_kept():
        for name in names:
            script: Script = importlib.import_module(f"workbench.studies.{name}.study").study
            if len(names) == 1:
                return [run_script(script, run)]
            run.say(f"study {name}")
            found.append(run_script(script, replace(run, folder=run.folder / name)))
    put(run.folder / "index.html", index(found).encode())
    return found
