"""`verify`: the true robot runs a path in closed loop, with commands of what is believed of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..arm import Array
from ..compensate import Compensation, Conditions, compensate
from ..faults import Fault, InputError
from ..paths import Path
from ..robot import Robot
from .control import Controller, nominal_mechanics
from .measures import Figures, Line, beside, figures, main_lines, normal, path_accuracy, tangents
from .mechanics import Mechanics, mechanics
from .motion import Motion, motion
from .simulation import STEP, Run, run

SPEEDS = (0.03, 0.3)  # m/s: as slow as source 003 drew, and ten times as fast
LONGEST = 60.0  # s that a run may take in the simulated world
NAMES = {
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


@dataclass(frozen=True)
class Repeats:
    """ISO 9283 over `count` runs at `speed` [m/s], in mm; None where no scatter of the joints is known."""

    name: str
    count: int
    speed: float
    at_mm: float
    rt_mm: float | None


@dataclass(frozen=True, eq=False)
class Verification:
    """The closed loop's verdict on a path. X: (N, 4, 4) desired tool poses; normal: (3,) of R_a, R_z.

    step_change_um: how far half the step moves the tool at most. expected_mm: RMS that the belief itself
    expects of the corrected path. notes: what was assumed or left out.
    """

    robot: Robot
    path: Path
    X: Array
    normal: Array
    series: tuple[Series, ...]
    repeats: tuple[Repeats, ...]
    step_change_um: float
    expected_mm: float
    notes: tuple[str, ...] = field(default=())

    @cached_property
    def slow(self) -> Series:
        """The slowest speed: nearly without dynamics."""
        return self.series[0]

    @property
    def ratio_to_perfect(self) -> float | None:
        """RMS error of the corrected path over that of a perfect model, at the slowest speed."""
        trials = self.slow.trials
        if "perfect" not in trials:
            return None
        return trials["corrected"].figures.rms_mm / trials["perfect"].figures.rms_mm


def verify(
    path: Path,
    truth: Robot,
    belief: Robot,
    conditions: Conditions | None = None,
    *,
    tool: Array | None = None,
    start: Array | None = None,
    speeds: Sequence[float] | None = SPEEDS,
    repeats: int = 10,
    controller: Controller | None = None,
    true_conditions: Conditions | None = None,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
) -> Verification:
    """Runs the path on the true robot, uncorrected and corrected by what is believed.

    truth, belief: robots with the corrections and effects of a model.toml. conditions: loads as the program
    believes them, `true_conditions` as they are (default: the same). speeds: tool speeds [m/s] to which the
    path's time is stretched; None: its own. repeats: runs for AT and RT. Raises `InputError`.
    """
    _same_robot(truth, belief)
    conditions = conditions or Conditions()
    job = _Job(
        truth,
        belief,
        conditions,
        true_conditions or conditions,
        controller or Controller(),
        tool,
        start,
        seed,
        progress,
    )
    timed = [_at_speed(path, job, speed) for speed in (speeds if speeds is not None else (None,))]
    timed = sorted({round(speed, 6): (p, speed) for p, speed in timed}.values(), key=lambda x: x[1])
    series = []
    for timed_path, speed in timed:
        series.append(job.series(timed_path, speed))
    fast_path, fast = timed[-1]
    repeated = job.repeats(fast_path, fast, repeats, series[-1])
    change = job.refine(fast_path, series[-1])
    done = job.last
    assert done is not None
    return Verification(
        truth,
        path,
        done.X_desired,
        normal(done.X_desired[:, :3, 3]),
        tuple(series),
        repeated,
        change,
        float(np.sqrt((done.after_mm**2).mean())),
        tuple(dict.fromkeys((*path.warnings, *job.notes))),
    )


def _same_robot(truth: Robot, belief: Robot) -> None:
    if truth.joint_names != belief.joint_names:
        place = str(truth.path or truth.name)
        what = f"has joints {', '.join(truth.joint_names)}; the model has {', '.join(belief.joint_names)}"
        raise InputError(Fault(place, what, "truth and model have to be the same robot"))


def _tool_speed(time: Array, p: Array) -> float:
    """Tool speed [m/s] that is hardly exceeded along a path p (N, 3)."""
    return float(np.quantile(np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(time), 0.95))


def _at_speed(path: Path, job: _Job, speed: float | None) -> tuple[Path, float]:
    """The path at a tool speed: its time stretched, within what a run may last."""
    own = _tool_speed(path.time, job.desired(path)[:, :3, 3])
    if own <= 0:
        raise InputError(Fault(path.file or path.title or "path", "the tool does not move", "give a path"))
    if speed is None:
        return path, own
    if not (np.isfinite(speed) and speed > 0):
        raise InputError(Fault("speed", f"is {speed} m/s", "give a number above zero"))
    stretch = own / speed
    length = float(path.time[-1] - path.time[0])
    if stretch * length > LONGEST:
        stretch = LONGEST / length
        job.notes.append(
            f"{speed:g} m/s would take {own / speed * length:.0f} s: run at {own / stretch:.3g} m/s instead"
        )
    return replace(path, time=path.time[0] + stretch * (path.time - path.time[0])), own / stretch


@dataclass(eq=False)
class _Job:
    """What all runs have in common."""

    truth: Robot
    belief: Robot
    conditions: Conditions
    true_conditions: Conditions
    controller: Controller
    tool: Array | None
    start: Array | None
    seed: int
    progress: Callable[[str], None]
    notes: list[str] = field(default_factory=list)
    last: Compensation | None = None
    made: dict[str, Compensation] = field(default_factory=dict)

    def compensate(self, path: Path, robot: Robot, conditions: Conditions, method: str) -> Compensation:
        return compensate(
            robot,
            path,
            conditions,
            tool=self.tool,
            start=self.start,
            method=method,
            bandwidth_hz=self.controller.bandwidth_hz,
            seed=self.seed,
        )

    def geometry(self, path: Path) -> Compensation:
        """Correction by geometry: the same at every speed."""
        if "geometry" not in self.made:
            self.made["geometry"] = self.compensate(path, self.belief, self.conditions, "geometry")
        return self.made["geometry"]

    def desired(self, path: Path) -> Array:
        return self.geometry(path).X_desired

    def commands(self, path: Path) -> dict[str, Array]:
        """Joints (N, n) of each variant."""
        geometry = self.geometry(path)
        everything = self.compensate(path, self.belief, self.conditions, "exact")
        self.last = everything
        self.notes += [line for line in everything.lines()[1:] if line not in self.notes]
        out = {
            "uncorrected": geometry.q_nominal,
            "geometry": geometry.q_command,
            "corrected": everything.q_command,
        }
        if self.truth is not self.belief:
            best = self.compensate(path, self.truth, self.true_conditions, "exact")
            out["perfect"] = best.q_command
        return out

    def series(self, path: Path, speed: float) -> Series:
        """All variants at one speed."""
        trials = {}
        p = self.desired(path)[:, :3, 3]
        for name, q in self.commands(path).items():
            self.progress(f"{NAMES[name].lower()}, {speed:g} m/s")
            done, moved = self.simulate(path, q)
            trials[name] = self._trial(name, done, moved, p)
        return Series(speed, moved.sample_times - moved.sample_times[0], trials)

    def simulate(
        self, path: Path, q: Array, step: float = STEP, offset: Array | None = None
    ) -> tuple[Run, Motion]:
        truth = mechanics(self.truth, path, q, self.true_conditions)
        nominal = nominal_mechanics(self.belief, mechanics(self.belief, path, q, self.conditions))
        moved = motion(path.time, q, bool(truth.gear) and sided_gear(truth))
        done = run(
            truth, nominal, moved, tool=self.tool, controller=self.controller, step=step, offset=offset
        )
        self.notes += [note for note in truth.notes if note not in self.notes]
        return done, moved

    def _trial(self, name: str, done: Run, moved: Motion, p: Array) -> Trial:
        error = done.tool[:, :3, 3] - p
        across = beside(error, tangents(p))
        shown = figures(error, across, error @ normal(p))
        lines = main_lines(moved.sample_times, across, done.q, self.orders())
        return Trial(name, error, across, done.q, done.motor, shown, lines, done.real_time_factor)

    def orders(self) -> list[tuple[str, int, float]]:
        """Gear orders that may show: of the joints' ratios, and of the effects of truth and belief."""
        out = []
        names = self.truth.joint_names
        for j, joint in enumerate(self.truth.joints):
            if joint.data.gear_ratio:
                out += [
                    (f"{joint.name}, {k} per motor turn", j, k * abs(joint.data.gear_ratio))
                    for k in (1, 2, 4)
                ]
        for item in (*self.truth.effects, *self.belief.effects):
            if item.order and item.joint in names:
                out.append(
                    (f"{item.joint}, {item.order:g} per joint turn", names.index(item.joint), item.order)
                )
        return out

    def repeats(self, path: Path, speed: float, count: int, series: Series) -> tuple[Repeats, ...]:
        """AT and RT: runs with the joints off by what their repeatability says."""
        sigma = np.array([joint.data.repeatability or 0.0 for joint in self.truth.joints])
        p = self.desired(path)[:, :3, 3]
        out = []
        for name in ("uncorrected", "corrected"):
            at, rt = path_accuracy([series.trials[name].across])
            if not sigma.any() or count < 2:
                out.append(Repeats(name, 1, speed, at, None))
                continue
            q = self.commands(path)[name]
            rng = np.random.default_rng([self.seed, 11])
            runs = []
            for i in range(count):
                self.progress(f"{NAMES[name].lower()}, repeat {i + 1} of {count}")
                done, _ = self.simulate(path, q, offset=sigma * rng.normal(size=len(sigma)))
                runs.append(beside(done.tool[:, :3, 3] - p, tangents(p)))
            at, rt = path_accuracy(runs)
            out.append(Repeats(name, count, speed, at, rt))
        return tuple(out)

    def refine(self, path: Path, series: Series) -> float:
        """[µm] how far half the step moves the tool."""
        self.progress("half the step")
        q = self.commands(path)["corrected"]
        fine, _ = self.simulate(path, q, STEP / 2)
        p = self.desired(path)[:, :3, 3]
        change = fine.tool[:, :3, 3] - p - series.trials["corrected"].error
        return float(1e6 * np.linalg.norm(change, axis=1).max())


def sided_gear(truth: Mechanics) -> bool:
    """Whether a gear's error depends on the side of approach."""
    q = np.zeros((1, truth.arm.n))
    one = np.ones_like(q)
    return bool((truth.gear_error(q, one) != truth.gear_error(q, -one)).any())


__all__ = ["Repeats", "Series", "Trial", "Verification", "verify"]
