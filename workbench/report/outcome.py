"""All files of a diagnosis in one folder, the extended robot included."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..diagnosis.all_over import with_bounds
from ..diagnosis.run import Outcome
from ..identification.model_file import fit_files
from . import write_all


def write_outcome(outcome: Outcome, folder: str | Path) -> None:
    """Writes result.json, index.html, report.pdf, scene.html and model.toml with its URDF: all, or
    none.

    The scene shows the pose that bends most, rigid, and its loaded twin with the deflection enlarged.
    """
    outcome, folder = with_bounds(outcome), Path(folder)
    fit = outcome.fit
    axial = outcome.problem.arm.own(fit.line.prediction.motion)
    n = int(np.argmax(np.abs(axial).sum(axis=1)))
    q = outcome.problem.q[n]
    bend = float(np.abs(axial[n]).max())
    ghost, label = None, ""
    if bend > 1e-7:
        factor = float(f"{0.1 / bend:.1g}")
        ghost, label = q + factor * axial[n], f"loaded, deflection × {factor:g}"
    files = fit_files(folder / "model.toml", fit)
    model = {path.relative_to(folder).as_posix(): text.encode() for path, text in files.items()}
    write_all(outcome.diagnosis, outcome.problem.robot, folder, q, ghost, label, model)
