"""`verify`: a robot runs a path in closed loop, with commands of what is believed of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...correction.conditions import Conditions, stated_conditions
from ...correction.paths import Path
from ...files.faults import Fault, InputError
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.loop import Loop
from .drives import drives
from .limits import OnLimit, OverLimit
from .measures import normal
from .mechanics import mechanics
from .modes import Modes, modes
from .outcomes import accuracy, orders, trial
from .plans import Plans
from .repeatability import repeatability
from .runs import FEED_FORWARD, FeedForward, Outcome, Task, World, simulate_all, simulate_to_limit
from .simulation import first_step
from .sweep import swept
from .tasks import others, repeated, settling
from .verification import COMMAND_NAMES, Series, Verification, speed_text

SPEEDS = (0.03, 0.3)  # m/s: as slow as Olabi et al. 2012 drew, and ten times as fast


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
    seed: int = 0,
    workers: int = 1,
    progress: Callable[[str], None] = lambda _: None,
) -> Verification:
    """Runs the path on the simulated robot, uncorrected and corrected by what is believed.

    path: N samples, joints [rad, m] or tool poses [m]; tool: (4, 4) pose of the tool in the flange frame;
    start: (n,) joints near the first pose.
    truth, belief: robots with the corrections and effects of a model.toml; where they are one, the result
    shows what the controller adds, and says so. conditions: what it carries (default: the tool that
    the belief states). speeds: tool speeds [m/s] to which the path's time is stretched; None: its own; from
    one on at which a drive is over its limit they are left out, if there are slower ones.
    repeats: runs for AT and RT. loop: the controller (default: that of the truth's TOML). feed_forward:
    "elastic" adds a command whose drives lead by what the arm yields under its inertia, "loop" also by what
    the model lags under the controller that it states (or `loop`). on_limit: whether a drive over its limit
    of torque or speed stops the run, or saturates. sweep: error by speed too. seed: of the repeats, and of
    the postures tried for the first pose. workers: processes. Raises `InputError` where the path cannot be
    run, or a drive is over its limit.

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
    world = World(truth, belief, loads, tool, loop or truth.loop, on_limit, known=loop or belief.loop)
    plans = Plans(world, path, start, seed)
    timed, notes = plans.at_speeds(speeds)
    if sweep and not timed[0][1]:
        what = "goes with a path along which the tool moves"
        raise InputError(Fault("--sweep", what, "leave it out: here the tool only turns"))
    commands = [plans.commands(p) for p, _ in timed]
    way = plans.way
    timed = [(way.along(p), speed) for p, speed in timed]
    world = replace(world, corners=way.corners)
    extra = FEED_FORWARD[1 : FEED_FORWARD.index(feed_forward) + 1]
    try:
        settled, left_out = _settled(world, settling(way.X, timed, commands), timed, workers, progress)
        timed, commands = timed[: len(settled)], commands[: len(settled)]
        tasks = others(way.X, timed, commands, settled, extra)
        tasks += repeated(truth, tasks[-1], commands[-1], repeats, seed)
        done = simulate_all(world, tasks, workers, progress)
        left = swept(world, way, path, commands[-1], workers, progress) if sweep else None
    except OverLimit as over:
        raise InputError(_over(path, over, truth)) from None
    rest = iter(done)
    p, lines = way.X[:, :3, 3], orders(truth, belief)
    series, said = list[Series](), list[list[str]]()
    for at, own, first in zip(timed, commands, settled, strict=True):
        outcomes = _outcomes(own, first, rest, extra)
        series.append(_series(world, at, outcomes, p, lines))
        said.append([*outcomes["corrected"].notes, *outcomes["uncorrected"].notes])
    return Verification(
        robot=truth,
        path=path,
        X=way.X,
        normal=normal(p),
        series=tuple(series),
        repeats=accuracy(series[-1], list(rest), p),
        expected_mm=plans.expected_mm,
        same=truth is belief,
        repeatability=repeatability(truth, plans.geometry.q_nominal),
        modes=_modes(world, timed[0][0], commands[0]["corrected"]),
        sweep=left,
        notes=tuple(dict.fromkeys([*path.warnings, *notes, *left_out, *plans.notes, *_told(series, said)])),
    )


def _settled(
    world: World,
    tasks: Sequence[Task],
    timed: Sequence[tuple[Path, float]],
    workers: int,
    progress: Callable[[str], None],
) -> tuple[list[Outcome], list[str]]:
    """Runs at all speeds up to the first at which a drive is over its limit, and a note on those left out.
    Raises OverLimit where that is the slowest."""
    done, over = simulate_to_limit(world, tasks, workers, progress)
    if over is None:
        return done, []
    if not done:
        raise over
    speeds = ", ".join(speed_text(speed) for _, speed in timed[len(done) :])
    return done, [f"not run at {speeds}: {over}"]


def _told(series: Sequence[Series], said: Sequence[Sequence[str]]) -> Iterator[str]:
    """The notes of the runs at each speed, with the speed where not all have them."""
    for one, own in zip(series, said, strict=True):
        for note in own:
            common = all(note in other for other in said)
            yield note if common else f"at {speed_text(one.speed)}: {note}"


def _outcomes(
    commands: Mapping[str, Array], corrected: Outcome, rest: Iterator[Outcome], extra: Sequence[str]
) -> dict[str, Outcome]:
    """All commands' runs at one speed; of the others than the corrected one they are the next of `rest`."""
    names = [name for name in (*commands, *extra) if name != "corrected"]
    return {"corrected": corrected} | {name: next(rest) for name in names}


def _series(
    world: World,
    timed: tuple[Path, float],
    outcomes: Mapping[str, Outcome],
    p: Array,
    lines: Sequence[tuple[str, int, float]],
) -> Series:
    (path, speed), corrected = timed, outcomes["corrected"]
    trials = {name: trial(outcomes[name], p, path.time, lines) for name in COMMAND_NAMES if name in outcomes}
    refined = corrected.step < 0.99 * first_step(world.loop)
    time = corrected.time - corrected.time[0]
    return Series(speed, time, trials, corrected.step, 1e6 * corrected.change, refined, corrected.gains)


def _over(path: Path, over: OverLimit, truth: Robot) -> Fault:
    """Where on the path a drive was asked for too much; at rest no speed makes it less."""
    mend = "run it slower (--speed), or let the drive saturate (--on-limit saturate)"
    if over.what == "torque" and over.time <= 0:
        mend = (
            f"at rest that is weight alone: state in {truth.urdf} what its drive bears (effort in "
            f"{over.unit}; 0: not known), or let it carry less"
        )
    return Fault(
        f"{path.file or path.title or 'path'}, {over.time:.3g} s after its start at rest", str(over), mend
    )


def _modes(world: World, path: Path, q: Array) -> Modes:
    """At the path's start; q: (N, n) commands."""
    truth = mechanics(world.truth, path, q, world.conditions)
    return modes(truth, drives(truth, q[0], world.loop), q[0])


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
