"""From files to files: a path, a model and a truth to a folder with the result."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...correction.conditions import Conditions
from ...correction.paths import Path as Wanted
from ...correction.paths import load_path
from ...files.digest import digests
from ...files.faults import Fault, InputError
from ...files.table_write import number_text, table_text
from ...report.folder import json_bytes, write_together
from ...report.numbers import mm
from ...robot.description import Robot, load_robot
from ...robot.kinematics import Array
from ...robot.loop import Loop
from .limits import OnLimit
from .proof import SPEEDS, verify
from .runs import FeedForward
from .verification import (
    COMMAND_NAMES,
    Verification,
    anew_said,
    perfect_said,
    speed_text,
    step_said,
    sweep_said,
)

DIGITS = 9  # of errors
WIDTH = max(map(len, COMMAND_NAMES.values()))


@dataclass(frozen=True, eq=False)
class Verified:
    """A verification and the files it wrote."""

    found: Verification
    files: tuple[Path, ...]

    def to_json(self) -> dict[str, Any]:
        """The numbers."""
        return self.found.to_json()

    @property
    def text(self) -> str:
        """What a user should know, for the terminal."""
        found = self.found
        lines = [found.caveat] if found.same else []
        lines += [f"{found.robot.title}, {found.path.title}: {found.judged} in closed loop"]
        for series in found.series:
            lines.append(
                f"  {f'at {speed_text(series.speed)}, mm':<{WIDTH}}"
                + "".join(f"{name:>9}" for name in ("mean", "RMS", "95 %", "max", "Ra", "Rz"))
            )
            for name, trial in series.trials.items():
                f = trial.figures
                values = (f.mean_mm, f.rms_mm, f.p95_mm, f.max_mm, f.ra_mm, f.rz_mm)
                lines.append(
                    f"  {COMMAND_NAMES[name]:<{WIDTH}}" + "".join(f"{mm(value):>9}" for value in values)
                )
            lines.append(f"  {found.repeatability.short}; {step_said(series)}")
        for r in found.repeats:
            rt = "not known" if r.rt_mm is None else f"{mm(r.rt_mm)} mm"
            runs = "one run" if r.count == 1 else f"{r.count} runs"
            what = f"{COMMAND_NAMES[r.name]}, {runs} at {speed_text(r.speed)}"
            lines.append(f"  {what}: AT {mm(r.at_mm)} mm, RT {rt}")
        lines.append(f"  {found.repeatability.said}")
        lines += [f"  {said}" for said in (anew_said(found), perfect_said(found.slow)) if said]
        if found.sweep is not None:
            lines.append(f"  {sweep_said(found.sweep)}")
        lines += [f"  note: {note}" for note in found.notes]
        return "\n".join([*lines, *(str(file) for file in self.files)])


def verify_file(
    path: str | Path,
    model: str | Path,
    truth: str | Path | None = None,
    out: str | Path | None = None,
    *,
    conditions: Conditions | None = None,
    tool: Array | None = None,
    start: Array | None = None,
    speeds: Sequence[float] | None = SPEEDS,
    repeats: int = 10,
    loop: Loop | None = None,
    feed_forward: FeedForward = "static",
    on_limit: OnLimit = "stop",
    sweep: bool = False,
    seed: int = 0,
    workers: int = 1,
    beside: Sequence[Path] = (),
    progress: Callable[[str], None] = lambda _: None,
) -> Verified:
    """Reads a path, a model and the truth (default: the model), simulates, and writes the result.

    Into `out` (None: nowhere): `verify.json`, `verify.html`, `scene.html`, `errors.csv`. beside: files that
    the other arguments were read from. Raises `InputError` with all faults of the files; nothing is written
    then.
    """
    wanted, belief, true_robot = _read(path, model, truth, out)
    found = verify(
        wanted,
        true_robot,
        belief,
        conditions,
        tool=tool,
        start=start,
        speeds=speeds,
        repeats=repeats,
        loop=loop,
        feed_forward=feed_forward,
        on_limit=on_limit,
        sweep=sweep,
        seed=seed,
        workers=workers,
        progress=progress,
    )
    found = replace(found, inputs=digests([Path(path), *belief.files, *true_robot.files, *beside]))
    return Verified(found, write_verification(found, Path(out)) if out is not None else ())


def _read(
    path: str | Path, model: str | Path, truth: str | Path | None, out: str | Path | None
) -> tuple[Wanted, Robot, Robot]:
    """The path, the model and the truth. Raises `InputError` with the faults of all, and of `out`."""
    faults: list[Fault] = []

    def tried(load: Callable[..., Any], *source: Any) -> Any:
        try:
            return load(*source)
        except InputError as error:
            faults.extend(error.faults)

    belief = tried(load_robot, model)
    true_robot = belief if truth is None else tried(load_robot, truth)
    wanted = tried(load_path, path, belief or true_robot)
    if out is not None and Path(out).exists() and not Path(out).is_dir():
        faults.append(Fault(str(out), "is a file, not a folder", "name a folder with --out"))
    if faults:
        raise InputError(faults)
    return wanted, belief, true_robot


def write_verification(found: Verification, folder: Path) -> tuple[Path, ...]:
    """Writes `verify.json`, `verify.html`, `scene.html`, `errors.csv`, all of them or none; their paths."""
    from .page import page
    from .scene import scene

    made = {
        "verify.json": json_bytes(found.to_json()),
        "verify.html": page(found).encode(),
        "scene.html": scene(found).encode(),
        "errors.csv": _errors(found).encode(),
    }
    return write_together(folder, made)


def _errors(found: Verification) -> str:
    """A row for each speed and point: when it is passed, where the tool should be and how far each command
    has it from there, in mm."""
    names = [name for name in COMMAND_NAMES if any(name in series.trials for series in found.series)]
    header = ["speed_m_s", "t_s", *(f"{axis}_mm" for axis in "xyz")]
    header += [f"{name}_{axis}_mm" for name in names for axis in "xyz"]
    rows = []
    for series in found.series:
        errors = [1e3 * series.trials[name].error for name in names]
        speed = np.full(len(series.time), series.speed)
        values = np.column_stack([speed, series.time, 1e3 * found.X[:, :3, 3], *errors])
        rows += [[number_text(value, DIGITS) for value in row] for row in values.tolist()]
    return table_text(header, rows)
