"""`compensate`: from a path and an extended robot to commands, and what they are worth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..effects.acting import Shares
from ..files.faults import Fault, InputError
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.rotations import nearest_turn, tool_pose
from .between import left_between
from .conditions import Conditions, stated_conditions
from .extended_arm import parts
from .mirror import METHODS
from .never_measured import never_measured
from .paths import Path
from .programs import LEAST_MM, Program
from .ripple import LeftOut, frequency, left_out, ripple_shares, speeds
from .solve import Rest, correct, first_step, settle, turning_sides
from .trajectory import Trajectory, trajectory_of
from .trouble import Trouble, impossible, near_singular, out_of_range, too_fast, unreached

EXACT = "exact"
BANDWIDTH_HZ = 10.0
COARSE = 8  # samples per cycle of a ripple, below which straight motion between them misses it
SHOWS_MM = 0.01  # left between samples, from which it is worth a word
PLACE = 0.5  # of the uncorrected error: when less is left by another base, that is worth a word
ROUGH = 1e-8  # rad, m: near enough to rest to tell the uncorrected error


@dataclass(frozen=True, eq=False)
class Compensation:
    """A path of N samples as commanded, and what it is worth by the model's own prediction.

    X_desired: (N, 4, 4) wanted tool poses; q_nominal: (N, n) joints that the nominal arm takes for them;
    q_command: (N, n) joints to command; X_command: (N, 4, 4) tool poses that the nominal controller has
    to be told to take them. before, after: (N, 6) way [m] and turn [rad] from the extended robot's tool
    to the path, uncorrected and corrected, what is left out included; between: (N − 1,) [m] what is left
    halfway from sample to sample (`left_between`). direction: (N, n) sides from which the joints come (None:
    no effect asks). trajectory: what it was made from.
    """

    path: Path
    method: str
    tool: Array
    X_desired: Array
    q_nominal: Array
    q_command: Array
    X_command: Array
    before: Array
    after: Array
    between: Array
    direction: Array | None
    left_out: tuple[LeftOut, ...]
    troubles: tuple[Trouble, ...]
    notes: tuple[str, ...]
    rounds: int
    trajectory: Trajectory

    def __repr__(self) -> str:
        before, after = self.before_mm, self.after_mm
        said = f"{self.path!r} by {self.method}"
        return f"Compensation of {said}: {before.mean():.4f} mm before, {after.mean():.4f} mm after"

    @property
    def sliding(self) -> tuple[bool, ...]:
        """Which joints slide."""
        return tuple(bool(slides) for slides in self.trajectory.nominal.prismatic)

    @property
    def position_only(self) -> bool:
        """The arm cannot turn its tool every way; it serves the place, and of the turn what it can."""
        return self.trajectory.tip.rows == 3

    @property
    def before_mm(self) -> Array:
        """(N,) distance of the uncorrected tool from the path."""
        return 1e3 * np.linalg.norm(self.before[:, :3], axis=1)

    @property
    def before_anew_mm(self) -> Array:
        """(N,) the same once the base or the work object is taken anew with the uncorrected tool."""
        return anew_mm(self.X_desired[:, :3, 3], -self.before[:, :3])

    @property
    def after_mm(self) -> Array:
        """(N,) distance of the corrected tool from the path."""
        return 1e3 * np.linalg.norm(self.after[:, :3], axis=1)

    @property
    def between_mm(self) -> float:
        """The most that is left halfway between samples that straight lines join."""
        return 1e3 * float(np.nanmax(self.between, initial=0.0))

    def program(self, name: str = "", kind: Literal["poses", "joints"] = "poses") -> Program:
        """The command as a program for a controller: tool poses, and joints for posture and rails; or
        joints only."""
        return Program(
            name,
            self.X_command,
            self.q_command,
            self.path.time,
            tool=self.tool,
            kind=kind,
            sliding=self.sliding,
        )

    def lines(self) -> list[str]:
        """What a user should know, a line each."""
        return [*self._expected(), *self.remarks()]

    def _expected(self) -> list[str]:
        """What the model expects of the path."""
        found = [
            f"{len(self.path)} samples, {self.path.time[-1] - self.path.time[0]:.6g} s: the model expects "
            f"{_size(self.before_mm)} uncorrected, {_size(self.after_mm)} corrected",
            "that is what the model leaves of its own errors; what to expect of the robot: workbench predict",
        ]
        if self.position_only:
            turned = 1e3 * float(np.linalg.norm(self.after[:, 3:], axis=1).max())
            found.append(
                "this arm cannot turn its tool every way: the place comes first, orientation as far as it "
                f"goes: it stays off by up to {turned:.2g} mrad"
            )
        anew = self.before_anew_mm
        if mostly_place(self.before_mm, anew):
            found.append(
                f"most of the uncorrected error is the same all along the path: {_size(anew)} once the base "
                "or the work object is taken anew"
            )
        if self.between_mm > SHOWS_MM:
            found.append(
                f"that is at its points: run straight from one to the next, up to {self.between_mm:.2g} mm "
                "are left halfway, which only closer points correct"
            )
        return found

    def remarks(self) -> list[str]:
        """What is left out, what is not well, and what was chosen or taken from elsewhere."""
        found = [f"left out: {item}" for item in self.left_out]
        for kind in dict.fromkeys(trouble.kind for trouble in self.troubles):
            here = [trouble for trouble in self.troubles if trouble.kind == kind]
            more = f", and {len(here) - 1} more of this kind" if len(here) > 1 else ""
            found.append(f"{kind}: {self.path.place(here[0].index)}: {here[0].what}{more}")
        return [*found, *self.notes]


def anew_mm(wanted: Array, error: Array) -> Array:
    """(N,) [mm] what is left of the errors (N, 3) [m] along a path of points (N, 3) [m] once the base or the
    work object is taken anew: beside the rigid motion that brings the path nearest to what was drawn."""
    drawn = wanted + error
    near, far = wanted - wanted.mean(axis=0), drawn - drawn.mean(axis=0)
    return np.asarray(1e3 * np.linalg.norm(near - far @ nearest_turn(far, near).T, axis=1))


def mostly_place(error_mm: Array, anew_mm: Array) -> bool:
    """Whether most of an error (N,) is the same all along the path."""
    return bool(np.square(anew_mm).mean() < PLACE**2 * np.square(error_mm).mean())


def _size(error_mm: Array) -> str:
    if error_mm.max() < LEAST_MM:
        return f"less than {LEAST_MM:g} mm"
    return f"{np.sqrt((error_mm**2).mean()):.3g} mm RMS ({error_mm.max():.3g} at most)"


def compensate(
    robot: Robot,
    path: Path,
    conditions: Conditions | None = None,
    *,
    tool: Array | None = None,
    start: Array | None = None,
    method: str = EXACT,
    bandwidth_hz: float = BANDWIDTH_HZ,
    seed: int = 0,
) -> Compensation:
    """The command that makes the extended robot's tool pass through the path.

    robot: with the corrections and effects of its model.toml. path: N samples, joints [rad, m] or tool
    poses [m]. conditions: what it carries (default: the tool that the model states). tool: (4, 4) pose of
    the tool in the flange frame (default: the flange). start: (n,) joints near the first pose, to choose
    the posture. method: "exact", or for comparison "mirror", "double", "joint" (first order) or "geometry".
    bandwidth_hz: a gear ripple that is faster at the path's speed is left out. seed: of the postures tried
    for the first pose.
    Raises `InputError` with the lines of the path that cannot be run; lesser troubles are in the result.

    >>> import numpy as np
    >>> from workbench import Path, compensate, load_robot, parse_effect, planned, problem, record, stored
    >>> robot = load_robot("cylindrical")
    >>> q = np.linspace([0.5, 0.2, 0.2], [1.0, 0.2, 0.3], 21)
    >>> ratio = parse_effect("gear_ratio:joint=joint_1,relative=5e-4", problem(planned(robot, q)))
    >>> model = stored("model.toml", robot, [record(*ratio)])  # diagnose writes such a file
    >>> command = compensate(model, Path(np.linspace(0, 2, 21), q=q))
    >>> f"{command.before_mm.max():.2f} mm uncorrected, {command.after_mm.max():.2f} mm corrected"
    '0.46 mm uncorrected, 0.00 mm corrected'
    """
    _check_call(method, bandwidth_hz)
    trajectory = trajectory_of(robot, path, conditions or stated_conditions(robot), tool, start, seed)
    needs_side = trajectory.extended.sided
    direction = turning_sides(trajectory.q) if needs_side else None
    before = settle(trajectory, trajectory.q, direction, still=ROUGH)
    speed = speeds(trajectory.q, path.time)
    shares: dict[int, Array] = {}
    if method == EXACT:
        shares = ripple_shares(trajectory.extended, speed, bandwidth_hz)
        first = first_step(trajectory, before, direction, shares)
        if direction is not None:
            direction = turning_sides(_behind_play(trajectory, first, direction))
        rest = correct(trajectory, first, direction, before.sag, shares)
        after = settle(trajectory, rest.q, direction, rest.sag) if shares else rest
    else:
        q, there = METHODS[method](trajectory, before, direction)
        after = settle(trajectory, q, direction, before.sag)
        rest = Rest(q, after.sag, after.error, there & after.there, after.rounds)
    troubles = _troubles(trajectory, before, rest)
    command = trajectory.forward(rest.q)
    return Compensation(
        path=path,
        method=method,
        tool=tool_pose(tool),
        X_desired=trajectory.X,
        q_nominal=trajectory.q,
        q_command=rest.q,
        X_command=command,
        before=before.error,
        after=after.error,
        between=left_between(trajectory, rest.q, command, direction),
        direction=direction,
        left_out=_left_out(trajectory, rest.q, speed, shares),
        troubles=troubles,
        notes=(
            *trajectory.extended.notes,
            *never_measured(trajectory),
            *_posture(trajectory, start),
            *_coarse(trajectory, speed, shares),
            *_wound_up(trajectory, rest.q, direction),
        ),
        rounds=rest.rounds,
        trajectory=trajectory,
    )


def judged(done: Compensation, q: Array) -> Compensation:
    """The same path with other joints (N, n) commanded, near those that correct it: what they leave."""
    trajectory = done.trajectory
    command, after = trajectory.forward(q), settle(trajectory, q, done.direction)
    between = left_between(trajectory, q, command, done.direction)
    return replace(done, q_command=q, X_command=command, after=after.error, between=between)


def _check_call(method: str, bandwidth_hz: float) -> None:
    if method not in (EXACT, *METHODS):
        raise InputError(
            Fault(f"method {method!r}", "no such method", f"one of {', '.join((EXACT, *METHODS))}")
        )
    if not bandwidth_hz > 0:
        raise InputError(Fault("bandwidth", f"is {bandwidth_hz} Hz", "give a number above zero"))


def _behind_play(trajectory: Trajectory, q: Array, direction: Array) -> Array:
    """(N, n) joints on the arm's side of what depends on the side of approach: which way the arm goes."""
    return q + _play(trajectory, q, direction)


def _play(trajectory: Trajectory, q: Array, direction: Array) -> Array:
    """(N, n) [rad, m] what the side of approach does to each joint."""
    ext, part = trajectory.extended, slice(0, len(q))
    play = ext.direct(ext.at(q, direction, part)) - ext.direct(ext.at(q, np.zeros_like(q), part))
    return np.asarray(play.reshape(len(q), -1)[:, trajectory.nominal.axial])


def _wound_up(trajectory: Trajectory, q: Array, direction: Array | None) -> Iterator[str]:
    """A note on joints that turn round along the path: what the side of approach does is corrected at once,
    and friction changes it over some of the way (Dahl 1968)."""
    if direction is None:
        return
    play = np.abs(_play(trajectory, q, direction))
    lever = np.concatenate([trajectory.jacobian(part)[:, :3] for part in parts(len(q))])
    left = 2e3 * play * np.linalg.norm(lever, axis=1)
    left[1:][direction[1:] * direction[:-1] >= 0] = left[0] = 0.0
    turning = (left > SHOWS_MM).sum(axis=0)
    if turning.any():
        names = ", ".join(trajectory.nominal.names[j] for j in np.flatnonzero(turning))
        yield (
            f"{names}: {turning.sum()} reversals along the path, corrected at once as for play; as far as it "
            f"is friction that winds up the gear, up to {left.max():.2g} mm are left for a while after"
        )


def _troubles(trajectory: Trajectory, before: Rest, rest: Rest) -> tuple[Trouble, ...]:
    """What is not well; raises `InputError` when the path cannot be run."""
    robot, path = trajectory.robot, trajectory.path
    singular = [
        trouble
        for part in parts(len(rest.q))
        for trouble in near_singular(
            trajectory.nominal, trajectory.tip, trajectory.jacobian(part), part.start
        )
    ]
    no_rest = "the loaded arm finds no rest: a stiffness is far too small for its load"
    found = unreached(before.there, no_rest, "rest")
    names = {trouble.index for trouble in singular}
    for trouble in unreached(rest.there & before.there | ~before.there, ""):
        near = " (near-singular)" if trouble.index in names else ""
        found.append(Trouble(trouble.index, "reach", f"the correction cannot be made here{near}"))
    found += out_of_range(robot, rest.q, "the corrected command")
    if faults := impossible(path, found):
        raise InputError(faults)
    return (*singular, *too_fast(robot, rest.q, path.time))


def _left_out(trajectory: Trajectory, q: Array, speed: Array, shares: Shares) -> tuple[LeftOut, ...]:
    """What the shares leave at the tool."""
    if not shares:
        return ()
    lever = np.concatenate([trajectory.jacobian(part)[:, :3] for part in parts(len(q))])
    return left_out(trajectory.extended, q, speed, shares, lever)


def _posture(trajectory: Trajectory, start: Array | None) -> Iterator[str]:
    """A note on the posture of a path of tool poses, where nobody chose it."""
    if trajectory.path.q is None and start is None:
        shown = zip(trajectory.q[0], trajectory.nominal.prismatic, strict=True)
        said = ",".join(f"{1e3 * q if slides else np.degrees(q):z.0f}" for q, slides in shown)
        units = "deg, mm" if any(trajectory.nominal.prismatic) else "deg"
        yield (
            f"the posture at the first pose is chosen here: joints {said} ({units}); where the arm stands "
            "otherwise, say so (--start): another posture wants another correction"
        )


def _coarse(trajectory: Trajectory, speed: Array, shares: Shares) -> list[str]:
    """Ripples that are commanded, and faster than the path's samples can draw, in one note."""
    rate = 1 / np.gradient(trajectory.path.time)
    labels, least, every = list[str](), np.inf, np.zeros(len(rate), dtype=bool)
    for i, (effect, _) in enumerate(trajectory.extended.acting):
        if effect.where.order is None:
            continue
        joint = trajectory.extended.problem.joint(effect.where.joint)
        commanded = shares.get(i, np.ones(len(rate))) > 0.01
        cycles = frequency(effect.where.order, speed[:, joint])
        few = commanded & (cycles * COARSE > rate)
        if few.any():
            labels.append(effect.label)
            least, every = min(least, float((rate[few] / cycles[few]).min())), every | few
    if not labels:
        return []
    return [
        f"{', '.join(dict.fromkeys(labels))}: down to {least:.2g} samples per cycle at {every.sum()} of "
        f"{len(every)} samples, from sample {int(np.flatnonzero(every)[0])}: between samples it is not "
        f"corrected; {COARSE} per cycle take a path sampled {int(np.ceil(COARSE / least))} times as closely"
    ]
