"""What a verification finds: numbers, errors along the path, and what was assumed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ...correction.command import anew_mm, mostly_place
from ...correction.paths import Path
from ...report.numbers import mm, significant
from ...robot.description import Robot
from ...robot.kinematics import Array
from .cascade import Gains
from .measures import Figures, Line
from .modes import Modes
from .repeatability import Repeatability

COMMAND_NAMES = {
    "uncorrected": "Uncorrected",
    "geometry": "Corrected by geometry only",
    "corrected": "Corrected by everything",
    "elastic": "… and elastic feed-forward",
    "loop": "… and predicted servo lag",
    "perfect": "What a perfect model would reach",
}

STILL = 1e-6  # m/s: a tool that is no faster turns or stands: its path runs in its own time
SAME = "The model ran against itself: this shows what the controller adds, not how accurate the robot is"


@dataclass(frozen=True, eq=False)
class Trial:
    """One variant of the command at one speed. error: (N, 3) [m] tool minus desired at the path's samples;
    across: (N, 3) its part across the path; links: (N, L, 4, 4) poses of base and links as simulated;
    motor: (N, n) servo error."""

    error: Array
    across: Array
    links: Array
    motor: Array
    figures: Figures
    lines: tuple[Line, ...]


@dataclass(frozen=True, eq=False)
class Series:
    """All variants at one speed [m/s]; time: (N,) [s] when the samples are passed.

    step: [s] of the integration; step_change_um: how far half of it moves the corrected tool at most;
    refined: the step was halved because of that; gains: of the drives, as the corrected path has them."""

    speed: float
    time: Array
    trials: dict[str, Trial]
    step: float
    step_change_um: float
    refined: bool
    gains: Gains

    @property
    def best(self) -> str:
        """Name of the command of what the model knows that leaves least, RMS."""
        tried = [name for name in ("corrected", "elastic", "loop") if name in self.trials]
        return min(tried, key=lambda name: self.trials[name].figures.rms_mm)

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
class Sweep:
    """RMS error [mm] by tool speed [m/s] (V,) of some commands: "rigid" (an arm that does not yield,
    corrected: what the controller alone leaves), "uncorrected", "corrected", "elastic". cut_s: where the path
    was longer, as much of it was run at each speed [s]; None: all of it at every speed."""

    speeds: Array
    rms_mm: dict[str, Array]
    cut_s: float | None = None

    def ends_at(self) -> int | None:
        """Number of the first speed at which the static correction leaves twice what it leaves at the
        slowest."""
        left = self.rms_mm["corrected"]
        over = np.flatnonzero(left > 2 * left[0])
        return int(over[0]) if len(over) else None

    def to_json(self) -> dict[str, Any]:
        return {
            "speeds_m_s": [_short(float(v)) for v in self.speeds],
            "rms_mm": {name: [_short(float(x)) for x in values] for name, values in self.rms_mm.items()},
        }


@dataclass(frozen=True, eq=False)
class Verification:
    """The closed loop's verdict on a path. X: (M, 4, 4) desired tool poses along it, between its rows too
    where they are far apart; normal: (3,) of R_a, R_z.

    series: slowest first. expected_mm: RMS that the belief itself expects of the corrected path, slow.
    same: the simulated robot is the model itself. repeatability: of the tool, by data sheet and joints.
    modes: the lowest, at the path's start. sweep: error by speed, None where it was not asked for.
    notes: what was assumed or left out.
    inputs: "<folder>/<file>" → SHA-256.
    """

    robot: Robot
    path: Path
    X: Array
    normal: Array
    series: tuple[Series, ...]
    repeats: tuple[Repeats, ...]
    expected_mm: float
    same: bool
    repeatability: Repeatability
    modes: Modes
    sweep: Sweep | None
    notes: tuple[str, ...]
    inputs: Mapping[str, str] = field(default_factory=dict)

    @property
    def caveat(self) -> str:
        """What the numbers stand for, where the simulated robot is the model: "" where it is not."""
        return SAME if self.same else ""

    @property
    def judged(self) -> str:
        """At how many points, in words."""
        rows, points = len(self.path), len(self.X)
        return f"{rows} samples" if rows == points else f"{rows} rows, judged at {points} points along them"

    @property
    def slow(self) -> Series:
        """The slowest speed: nearly without dynamics."""
        return self.series[0]

    @property
    def anew_rms_mm(self) -> float | None:
        """RMS of the uncorrected error, slow, once the base or the work object is taken anew; None where that
        takes little of it."""
        error = self.slow.trials["uncorrected"].error
        left = anew_mm(self.X[:, :3, 3], error)
        if not mostly_place(1e3 * np.linalg.norm(error, axis=1), left):
            return None
        return float(np.sqrt(np.square(left).mean()))

    def to_json(self) -> dict[str, Any]:
        """All numbers; lengths in mm as the keys say."""
        return {
            "schema": 1,
            "truth_is_model": self.same,
            "caveat": self.caveat,
            "pose_repeatability_mm": _short(self.repeatability.data_sheet_mm),
            "joints_repeatability_mm": _short(self.repeatability.joints_mm),
            "modes_hz": self.modes.to_json(),
            "robot": self.robot.name,
            "path": self.path.title,
            "samples": len(self.path),
            "judged_at": len(self.X),
            "normal": [round(float(x), 6) for x in self.normal],
            "speeds": [
                {
                    "speed_m_s": _short(series.speed),
                    "duration_s": _short(float(series.time[-1])),
                    "ratio_to_perfect": _short(series.ratio_to_perfect),
                    "step_s": _short(series.step),
                    "step_change_um": _short(series.step_change_um),
                    "refined": series.refined,
                    "gains": series.gains.to_json(),
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
            "sweep": None if self.sweep is None else self.sweep.to_json(),
            "expected_rms_mm": _short(self.expected_mm),
            "uncorrected_anew_rms_mm": _short(self.anew_rms_mm),
            "notes": list(self.notes),
            "inputs": dict(self.inputs),
        }


def speed_text(speed: float) -> str:
    """A tool speed [m/s] for people."""
    return f"{speed:.3g} m/s" if speed > STILL else "the path's own speed"


def step_said(series: Series) -> str:
    """What the step of the integration was worth at a speed."""
    said = f"step {1e3 * series.step:.3g} ms"
    if series.refined:
        said += ", refined by itself"
    return f"{said}: half of it moves the tool by {significant(series.step_change_um, 2)} µm at most"


def perfect_said(series: Series) -> str:
    """How the corrected path compares with what a perfect model would reach; "" where that is not known."""
    ratio = series.ratio_to_perfect
    if ratio is None:
        return ""
    reached, perfect = (mm(series.trials[name].figures.rms_mm) for name in ("corrected", "perfect"))
    if reached == perfect:
        return f"A model without any error would reach the same {perfect} mm"
    return f"A model without any error would reach {perfect} mm; this one comes to {ratio:.2f} times that"


def anew_said(found: Verification) -> str:
    """How much of the uncorrected error is the same all along the path; "" where it is little."""
    left = found.anew_rms_mm
    if left is None:
        return ""
    return (
        f"Most of the uncorrected error is the same all along the path: {mm(left)} mm RMS are left of it "
        "once the base or the work object is taken anew"
    )


def sweep_said(sweep: Sweep) -> str:
    """Where the static correction ends, in words."""
    k = sweep.ends_at()
    of = "" if sweep.cut_s is None else f" (at most {sweep.cut_s:g} s of the path at each speed)"
    if k is None:
        return f"the static correction holds up to {sweep.speeds[-1]:.3g} m/s{of}"
    left, led = (mm(float(sweep.rms_mm[name][k])) for name in ("corrected", "elastic"))
    lead = "with elastic feed-forward or without" if led == left else f"{led} mm with elastic feed-forward"
    slowest, below, there = (f"{float(sweep.speeds[i]):.3g}" for i in (0, k - 1, k))
    return (
        f"between {below} and {there} m/s the static correction comes to leave twice what it leaves at "
        f"{slowest} m/s: {left} mm at {there} m/s, {lead}{of}"
    )


def _line(line: Line) -> dict[str, Any]:
    return {
        "frequency_hz": _short(line.frequency_hz),
        "amplitude_mm": _short(line.amplitude_mm),
        "gear": line.cause,
    }


def _short(value: float | None) -> float | None:
    """Six significant digits."""
    return None if value is None else float(f"{value:.6g}")
