"""What a verification finds: numbers, errors along the path, and what was assumed."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...correction.paths import Path
from ...robot.description import Robot
from ...robot.kinematics import Array
from .measures import Figures, Line

COMMAND_NAMES = {
    "uncorrected": "Uncorrected",
    "geometry": "Corrected by geometry only",
    "corrected": "Corrected by everything",
    "perfect": "What a perfect model would reach",
}


@dataclass(frozen=True, eq=False)
class Trial:
    """One variant of the command at one speed. error: (N, 3) [m] tool minus desired at the path's samples;
    across: (N, 3) its part across the path; q: (N, n) of the arm as it was; motor: (N, n) servo error."""

    name: str
    error: Array
    across: Array
    q: Array
    motor: Array
    figures: Figures
    lines: tuple[Line, ...]
    real_time_factor: float


@dataclass(frozen=True, eq=False)
class Series:
    """All variants at one speed [m/s]; time: (N,) [s] when the samples are passed."""

    speed: float
    time: Array
    trials: dict[str, Trial]

    @property
    def ratio_to_perfect(self) -> float | None:
        """RMS error of the corrected path over that of a perfect model."""
        if "perfect" not in self.trials:
            return None
        return self.trials["corrected"].figures.rms_mm / self.trials["perfect"].figures.rms_mm


@dataclass(frozen=True)
class Repeats:
    """ISO 9283 over `count` runs at `speed` [m/s], in mm; RT None where no scatter of the joints is known."""

    name: str
    count: int
    speed: float
    at_mm: float
    rt_mm: float | None


@dataclass(frozen=True, eq=False)
class Verification:
    """The closed loop's verdict on a path. X: (N, 4, 4) desired tool poses; normal: (3,) of R_a, R_z.

    series: slowest first. step_change_um: how far half the step moves the tool at most, at the fastest.
    expected_mm: RMS that the belief itself expects of the corrected path, slow. notes: what was assumed or
    left out.
    """

    robot: Robot
    path: Path
    X: Array
    normal: Array
    series: tuple[Series, ...]
    repeats: tuple[Repeats, ...]
    step_change_um: float
    expected_mm: float
    notes: tuple[str, ...]

    @property
    def slow(self) -> Series:
        """The slowest speed: nearly without dynamics."""
        return self.series[0]

    def to_json(self) -> dict[str, Any]:
        """All numbers; lengths in mm as the keys say."""
        return {
            "schema": 1,
            "robot": self.robot.name,
            "path": self.path.title,
            "samples": len(self.path),
            "normal": [round(float(x), 6) for x in self.normal],
            "speeds": [
                {
                    "speed_m_s": _short(series.speed),
                    "duration_s": _short(float(series.time[-1])),
                    "ratio_to_perfect": _short(series.ratio_to_perfect),
                    "commands": {
                        name: {key: _short(value) for key, value in asdict(trial.figures).items()}
                        | {"servo_max": _short(float(np.abs(trial.motor).max()))}
                        | {"lines": [_line(line) for line in trial.lines]}
                        for name, trial in series.trials.items()
                    },
                }
                for series in self.series
            ],
            "iso_9283": [
                {
                    "command": r.name,
                    "runs": r.count,
                    "speed_m_s": _short(r.speed),
                    "at_mm": _short(r.at_mm),
                    "rt_mm": _short(r.rt_mm),
                }
                for r in self.repeats
            ],
            "step_change_um": _short(self.step_change_um),
            "expected_rms_mm": _short(self.expected_mm),
            "notes": list(self.notes),
        }


def _line(line: Line) -> dict[str, Any]:
    return {
        "frequency_hz": _short(line.frequency_hz),
        "amplitude_mm": _short(line.amplitude_mm),
        "gear": line.cause,
    }


def _short(value: float | None) -> float | None:
    """Six significant digits."""
    return None if value is None else float(f"{value:.6g}")
