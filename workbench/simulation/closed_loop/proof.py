"""`verify`: a robot runs a path in closed loop, with commands of what is believed of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ...correction import Compensation, Conditions, compensate, stated_conditions
from ...correction.paths import Path
from ...files.faults import Fault, InputError
from ...robot.description import Robot
from ...robot.kinematics import Array, frames
from ...robot.loop import Loop
from ...robot.rigid_plant import arrays
from .drives import drives
from .limits import OnLimit, OverLimit
from .machine import machine, modes
from .measures import beside, figures, main_lines, normal, path_accuracy, tangents
from .mechanics import mechanics
from .runs import FEED_FORWARD, FeedForward, Outcome, Task, World, simulate_all
from .sweep import swept
from .verification import COMMAND_NAMES, Repeats, Series, Trial, Verification

SPEEDS = (0.03, 0.3)  # m/s: as slow as Olabi et al. 2012 drew, and ten times as fast
LEAST_TOLD = 1e-9  # rad, m: by which a command has to differ to be run beside another
LONGEST = 60.0  # s that a run may take in the simulated world


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
    loop: Loop | None = None,
    feed_forward: FeedForward = "static",
    on_limit: OnLimit = "stop",
    sweep: bool = False,
    true_conditions: Conditions | None = None,
    seed: int = 0,
    workers: int = 1,
    progress: Callable[[str], None] = lambda _: None,
) -> Verification:
    """Runs the path on the simulated robot, uncorrected and corrected by what is believed.

    path: N samples, joints [rad, m] or tool poses [m]; tool: (4, 4) pose of the tool in the flange frame;
    start: (n,) joints near the first pose.
    truth, belief: robots with the corrections and effects of a model.toml; where they are one, the result
    shows what the controller adds, and says so. conditions: loads as the program believes them,
    `true_conditions` as they are (default: the same). speeds: tool speeds [m/s] to which the path's time is
    stretched; None: its own. repeats: runs for AT and RT. loop: the controller (default: that of the truth's
    TOML). feed_forward: "elastic" adds a command whose drives lead by what the arm yields under its inertia,
    "loop" also by what the model's own loop lags. on_limit: whether a drive over its limit of torque or
    speed stops the run, or saturates. sweep: error by speed too. workers: processes. Raises `InputError`
    where the path cannot be run, or a drive is over its limit.

    >>> import numpy as np
    >>> from workbench import Path, load_robot, parse_effect, planned, problem, record, stored, verify
    >>> robot = load_robot("cylindrical")
    >>> q = np.linspace([0.5, 0.2, 0.2], [1.0, 0.2, 0.3], 21)
    >>> ratio = parse_effect("gear_ratio:joint=joint_1,relative=5e-4", problem(planned(robot, q)))
    >>> truth = stored("truth.toml", robot, [record(*ratio)])
    >>> found = verify(Path(np.linspace(0, 2, 21), q=q), truth, belief=truth, speeds=None, repeats=0)
    >>> runs = found.slow.trials
    >>> runs["corrected"].figures.rms_mm < 0.05 * runs["uncorrected"].figures.rms_mm
    True
    """
    _check_call(truth, belief, speeds, repeats)
    loads = conditions or stated_conditions(belief)
    world = World(truth, belief, loads, true_conditions or loads, tool, loop or truth.loop, on_limit=on_limit)
    plans = _Plans(world, path, start, seed)
    timed, notes = plans.at_speeds(speeds)
    commands = [plans.commands(p) for p, _ in timed]
    extra = FEED_FORWARD[1 : FEED_FORWARD.index(feed_forward) + 1]
    try:
        settled = simulate_all(world, _settling(plans.desired, timed, commands), workers, progress)
        tasks = _others(plans.desired, timed, commands, settled, extra)
        tasks += _repeated(truth, tasks[-1], commands[-1], repeats, seed)
        done = simulate_all(world, tasks, workers, progress)
        left = swept(world, plans.desired, path, commands[-1], workers, progress) if sweep else None
    except OverLimit as over:
        raise InputError(_over(path, over)) from None
    p = plans.desired[:, :3, 3]
    orders = _orders(truth, belief)
    series, place = [], 0
    for (_, speed), variants, first in zip(timed, commands, settled, strict=True):
        names = [name for name in (*variants, *extra) if name != "corrected"]
        outcomes = {"corrected": first} | dict(zip(names, done[place:], strict=False))
        place += len(names)
        trials = {name: _trial(name, outcomes[name], p, orders) for name in COMMAND_NAMES if name in outcomes}
        refined = first.step < 0.99 * world.loop.drive_period
        series.append(
            Series(speed, first.time - first.time[0], trials, first.step, 1e6 * first.change, refined)
        )
    return Verification(
        robot=truth,
        path=path,
        X=plans.desired,
        normal=normal(p),
        series=tuple(series),
        repeats=_accuracy(series[-1], done[place:], p),
        expected_mm=plans.expected_mm,
        same=truth is belief,
        repeatability_mm=_repeatability(truth, plans.geometry.q_nominal),
        modes_hz=_modes(world, path, commands[0]["corrected"]),
        sweep=left,
        notes=tuple(dict.fromkeys([*path.warnings, *notes, *plans.notes, *settled[0].notes, *done[0].notes])),
    )


def _settling(X: Array, timed: list[tuple[Path, float]], commands: list[dict[str, Array]]) -> list[Task]:
    """The corrected path at each speed, which settles the step for the others."""
    return [
        Task(f"corrected by everything, {speed:.3g} m/s", p, q["corrected"], X, settled=True)
        for (p, speed), q in zip(timed, commands, strict=True)
    ]


def _others(
    X: Array,
    timed: list[tuple[Path, float]],
    commands: list[dict[str, Array]],
    settled: list[Outcome],
    extra: Sequence[FeedForward],
) -> list[Task]:
    """All other commands at each speed; `extra` ones are the corrected command with drives that lead."""
    tasks = []
    for (p, speed), variants, first in zip(timed, commands, settled, strict=True):
        for name, q in variants.items():
            if name != "corrected":
                said = f"{COMMAND_NAMES[name].lower()}, {speed:.3g} m/s"
                tasks.append(Task(said, p, q, X, step=first.step))
        for name in extra:
            said = f"{name} feed-forward, {speed:.3g} m/s"
            tasks.append(Task(said, p, variants["corrected"], X, step=first.step, ahead=name))
    return tasks


def _over(path: Path, over: OverLimit) -> Fault:
    """Where on the path a drive was asked for too much."""
    mend = "run it slower (--speed), or let the drive saturate (--on-limit saturate)"
    return Fault(
        f"{path.file or path.title or 'path'}, {over.time:.3g} s after its start at rest", str(over), mend
    )


def _repeatability(robot: Robot, q: Array) -> float | None:
    """[mm] of ISO 9283's pose repeatability, l̄ + 3 S, that the joints' own makes at the middle of a path."""
    sigma = np.array([joint.data.repeatability or 0.0 for joint in robot.joints])
    if not sigma.any():
        return None
    arm = arrays(robot)
    q = q[len(q) // 2]
    scattered = q + sigma * np.random.default_rng(0).normal(size=(2000, len(q)))
    where = frames(arm, scattered).p[-1]
    away = 1e3 * np.linalg.norm(where - where.mean(axis=0), axis=1)
    return float(away.mean() + 3 * away.std(ddof=1))


def _modes(world: World, path: Path, q: Array, count: int = 3) -> tuple[float, ...]:
    """Lowest natural frequencies [Hz] at the path's start, drives locked."""
    truth = mechanics(world.truth, path, q, world.true_conditions)
    built = machine(truth, drives(truth, q[0], world.loop).rotor)
    return tuple(float(f) for f in modes(built, q[0])[:count] / (2 * np.pi)) if len(built.springs) else ()


def _check_call(truth: Robot, belief: Robot, speeds: Sequence[float] | None, repeats: int) -> None:
    faults = []
    if truth.joint_names != belief.joint_names:
        what = f"has joints {', '.join(truth.joint_names)}; the model has {', '.join(belief.joint_names)}"
        faults.append(Fault(str(truth.path or truth.name), what, "truth and model have to be the same robot"))
    elif truth.urdf.name != belief.urdf.name:
        what = f"is made from {truth.urdf.name}, the model from {belief.urdf.name}"
        faults.append(Fault(str(truth.path or truth.name), what, "truth and model have to be the same robot"))
    faults += [
        Fault("speed", f"is {speed} m/s", "give a number above zero")
        for speed in speeds or ()
        if not (np.isfinite(speed) and speed > 0)
    ]
    if speeds is not None and not len(speeds):
        faults.append(Fault("speeds", "none is given", "give one at least"))
    if repeats < 0:
        faults.append(Fault("repeats", f"is {repeats}", "give zero or more"))
    if faults:
        raise InputError(faults)


@dataclass(eq=False)
class _Plans:
    """The commands that are run."""

    world: World
    path: Path
    start: Array | None
    seed: int

    def __post_init__(self) -> None:
        world = self.world
        self.notes: list[str] = []
        self.expected_mm = 0.0
        # geometry and the nominal joints are the same at every speed
        self.geometry = self._compensate(self.path, world.belief, world.conditions, "geometry")
        self.desired = self.geometry.X_desired

    def _compensate(self, path: Path, robot: Robot, conditions: Conditions, method: str) -> Compensation:
        world = self.world
        return compensate(
            robot,
            path,
            conditions,
            tool=world.tool,
            start=self.start,
            method=method,
            bandwidth_hz=world.loop.feed_forward_hz,
            seed=self.seed,
        )

    def commands(self, path: Path) -> dict[str, Array]:
        """Joints (N, n) of each variant."""
        world = self.world
        everything = self._compensate(path, world.belief, world.conditions, "exact")
        self.notes += everything.lines()[1:]
        if not self.expected_mm:
            self.expected_mm = float(np.sqrt((everything.after_mm**2).mean()))
        out = {"uncorrected": self.geometry.q_nominal, "corrected": everything.q_command}
        if np.abs(self.geometry.q_command - self.geometry.q_nominal).max() > LEAST_TOLD:
            out["geometry"] = self.geometry.q_command
        if world.truth is not world.belief:
            best = self._compensate(path, world.truth, world.true_conditions, "exact")
            out["perfect"] = best.q_command
        return out

    def at_speeds(self, speeds: Sequence[float] | None) -> tuple[list[tuple[Path, float]], list[str]]:
        """The path at each tool speed, slowest first: its time stretched, within what a run may last."""
        p, time = self.desired[:, :3, 3], self.path.time
        own = float(np.quantile(np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(time), 0.95))
        if own <= 0:
            place = self.path.file or self.path.title or "path"
            raise InputError(Fault(place, "the tool does not move", "give a path"))
        length, found, notes = float(time[-1] - time[0]), {}, []
        for speed in speeds if speeds is not None else (own,):
            stretch = min(own / speed, LONGEST / length)
            if stretch < own / speed:
                took = f"{speed:g} m/s would take {own / speed * length:.0f} s"
                notes.append(f"{took}: run at {own / stretch:.3g} m/s instead")
            found[round(own / stretch, 9)] = replace(
                self.path, time=time[0] + stretch * (time - time[0])
            )  # fmt: skip
        return [(found[speed], speed) for speed in sorted(found)], notes


def _repeated(
    truth: Robot, like: Task, commands: dict[str, Array], count: int, seed: int
) -> list[Task]:  # fmt: skip
    """Runs with the joints off by what their repeatability says."""
    sigma = np.array([joint.data.repeatability or 0.0 for joint in truth.joints])
    if not sigma.any() or count < 2:
        return []
    offsets = sigma * np.random.default_rng([seed, 11]).normal(size=(count, len(sigma)))
    return [
        Task(
            f"{COMMAND_NAMES[name].lower()}, repeat {i} of {count}",
            like.path,
            commands[name],
            like.X,
            step=like.step,
            offset=offset,
        )
        for name in ("uncorrected", "corrected")
        for i, offset in enumerate(offsets, 1)
    ]


def _accuracy(series: Series, repeated: list[Outcome], p: Array) -> tuple[Repeats, ...]:
    """AT and RT at the series' speed; RT is unknown without repeated runs."""
    names, count = ("uncorrected", "corrected"), len(repeated) // 2
    if not count:
        single = [path_accuracy([series.trials[name].across])[0] for name in names]
        return tuple(Repeats(name, 1, series.speed, at, None) for name, at in zip(names, single, strict=True))
    across = [beside(outcome.tool[:, :3, 3] - p, tangents(p)) for outcome in repeated]
    return tuple(
        Repeats(name, count, series.speed, *path_accuracy(across[a:b]))
        for name, (a, b) in zip(names, pairwise((0, count, 2 * count)), strict=True)
    )


def _trial(name: str, done: Outcome, p: Array, orders: Sequence[tuple[str, int, float]]) -> Trial:
    error = done.tool[:, :3, 3] - p
    across = beside(error, tangents(p))
    return Trial(
        name,
        error,
        across,
        done.q,
        done.motor,
        figures(error, across, error @ normal(p)),
        main_lines(done.time, across, done.q, orders),
        done.real_time_factor,
    )


def _orders(truth: Robot, belief: Robot) -> list[tuple[str, int, float]]:
    """Gear orders that may show: of the joints' ratios, and of the effects of truth and belief."""
    names = truth.joint_names
    out = [
        (f"{joint.name}, {k} per motor turn", j, k * abs(joint.data.gear_ratio))
        for j, joint in enumerate(truth.joints)
        if joint.data.gear_ratio
        for k in (1, 2, 4)
    ]
    stated = {(i.joint, i.order) for i in (*truth.effects, *belief.effects) if i.order and i.joint in names}
    for joint_name, order in sorted(stated):
        assert joint_name is not None
        assert order is not None
        out.append((f"{joint_name}, {order:g} per joint turn", names.index(joint_name), order))
    return out
