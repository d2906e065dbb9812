"""path.csv: the workbench's own table of a path, also for controllers that no other format serves.

Columns and rules are those of `correction/paths.py`, with `dwell_s` where the robot is to stand. Written
are quaternions, free of gimbal lock.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from ...files.faults import Fault
from ..paths import PATH_DIGITS, Path, parse_path, path_text
from .base import Program
from .format import Format


class Csv(Format):
    name, title, extension, newline = "csv", "CSV", ".csv", "\n"
    mm_digits, deg_digits = PATH_DIGITS - 6, PATH_DIGITS - 3  # decimals within 100 m and 1000°
    arm_joints = None
    most_rails = None
    carries_tool = False
    own_joints = False
    samples = True

    def rounding(self) -> tuple[float, float]:
        return super().rounding()[0], 4 * 0.5 * 10.0**-PATH_DIGITS

    def _check_name(self, program: Program) -> list[Fault]:
        """A table has no name inside; the file may be named at will."""
        bad = re.search(r'[/\\:*?"<>|]', program.name)
        what, mend = "has a character that files cannot have", f"say {self.legal_name(program.name)!r}"
        return [Fault(f"program name {program.name!r}", what, mend)] if bad else []

    def legal_name(self, text: str) -> str:
        return re.sub(r'[/\\:*?"<>|]+', "_", text) or "path"

    def write(self, program: Program) -> dict[str, str]:
        joints, time = program.kind == "joints", program.time
        if time is None:  # then a second a point, and its dwell
            time = np.concatenate([[0.0], np.cumsum(1.0 + program.dwell[:-1])])
        path = Path(
            time,
            q=program.q if joints else None,
            X=None if joints else program.X,
            dwell=program.dwell if program.dwell.any() else None,
            sliding=program.sliding,
        )
        return {f"{program.name or 'path'}{self.extension}": path_text(path)}

    def read(self, files: Mapping[str, str]) -> Program:
        file, text = next(iter(files.items()))
        path = parse_path(text, file)
        return Program(
            path.title,
            path.X,
            path.q,
            path.time,
            np.zeros(1) if path.dwell is None else path.dwell,
            kind="poses" if path.q is None else "joints",
            sliding=path.sliding,
        )
