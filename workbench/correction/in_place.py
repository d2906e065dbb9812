"""An existing robot program with its targets corrected, and everything else in it untouched byte for byte."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files.digest import digests
from ..files.faults import Fault, InputError
from ..robot.description import Robot, load_robot
from ..robot.kinematics import Array
from ..robot.kinematics import frames as frames_at
from ..robot.rigid_plant import arrays
from ..robot.schema import LoadData
from .command import Compensation, compensate, judged
from .conditions import Conditions, alike, carried, stated_conditions
from .inverse import newton
from .paths import Path
from .program_postures import joints_at
from .program_targets import Frames, Given, Target, targets_of, times_of
from .programs import Format, find_format, formats
from .programs.files import beside, is_folder, put_files
from .programs.motions import Move, Spot
from .trajectory import rigid
from .trouble import near_singular, ranges_of

NAMED_ALIKE = (".dat",)  # belongs to a program by its name
SAME_MM = 1e-3  # corrections of one target that differ by less are the same


@dataclass(frozen=True, eq=False)
class Corrected:
    """A corrected program on disk: how many targets, how far they were moved, and what was left alone.
    compensation: by the numbers that were written. shared: targets that are used where another correction is
    right. inputs: "<folder>/<file>" → SHA-256."""

    compensation: Compensation
    files: tuple[pathlib.Path, ...]
    targets: int
    shared: int
    notes: tuple[str, ...]
    inputs: Mapping[str, str]

    def lines(self) -> list[str]:
        """What a user should know, a line each."""
        again = f", {self.shared} of them used again where another correction is right" if self.shared else ""
        return [f"{self.targets} targets corrected{again}", *self.compensation.lines(), *self.notes]

    @property
    def text(self) -> str:
        """For the terminal."""
        return "\n".join([*self.lines(), *(str(file) for file in self.files)])

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        before, after = self.compensation.before_mm, self.compensation.after_mm
        return {
            "schema": 1,
            "files": [str(file) for file in self.files],
            "targets": self.targets,
            "shared_targets": self.shared,
            "before_max_mm": float(before.max()),
            "after_max_mm": float(after.max()),
            "between_max_mm": self.compensation.between_mm,
            "notes": list(self.notes),
            "inputs": dict(self.inputs),
        }


def is_program(path: pathlib.Path) -> bool:
    """Whether the file is a controller's program, by its extension."""
    own = {end for format in formats().values() if not format.samples for end in format.extensions}
    return path.suffix.lower() in own


def compensate_program(
    path: str | pathlib.Path,
    model: str | pathlib.Path,
    out: str | pathlib.Path | None = None,
    *,
    format: str | None = None,
    conditions: Conditions | None = None,
    tool: Given = None,
    base: Given = None,
    start: Array | None = None,
    as_urdf: bool = False,
    keep: bool = False,
) -> Corrected:
    """Corrects the targets of a KRL, RAPID, VAL 3, LS or URScript program for the model's robot, only these.

    out: a folder (default: NAME_compensated beside the program) or a file with the same extension. tool and
    base: (4, 4) where the program's own stand on the controller, not in the file; of several each by the name
    that the program has for it. start: (6,) the URDF's joints [rad] before the first target, where the file
    does not say the posture. Between targets the arm moves as before: what depends on the joints in between
    is corrected at the targets only. Raises `InputError`; nothing is written then.
    """
    source, robot = pathlib.Path(path), load_robot(model)
    chosen = find_format(format) if format else _by_extension(source)
    texts, codec = _texts(source)
    read = digests([*(source.parent / name for name in texts), *robot.files])
    motions = chosen.scan(texts)
    moves = [move for move in motions.moves if move.spot is not None]
    if not moves:
        raise InputError(motions.faults or [Fault(str(source), "has no target that could be corrected")])
    frames = Frames(robot, as_urdf, tool, base)
    remarks = frames.check(moves)
    conditions, more = _carrying(robot, frames, moves, conditions or stated_conditions(robot))
    remarks += more
    targets = targets_of(moves)
    q, postures = joints_at(robot, frames, targets, start)
    kept, alone = _without_singular(robot, targets, q)
    kept = 2 * kept if len(kept) == 1 else kept  # a path has two samples at least
    targets, q = [targets[i] for i in kept], q[kept]
    lines = tuple(target.move.line for target in targets)
    in_files = tuple(target.move.file for target in targets)
    told = Path(times_of(targets), q=q, title=source.stem, file=source.name, lines=lines, files=in_files)
    several, of = np.unique(np.array(_tools(frames, targets)), axis=0, return_inverse=True)
    runs = [compensate(robot, told, conditions, tool=tool) for tool in several]
    asked = _at_own_tools(runs, of, targets)
    edits, again = _edits(chosen, texts, frames, targets, asked)
    texts = _changed(texts, edits)
    back = targets_of([move for move in chosen.scan(texts).moves if move.spot is not None])
    q = _as_written(robot, frames, [back[i] for i in kept], asked.q_command)
    done = _at_own_tools([judged(run, q) for run in runs], of, targets)
    shared, notes = _shared(targets, again, asked, done)
    notes += [*remarks, *postures]
    notes += list(dict.fromkeys(str(remark) for remark in motions.remarks))
    notes += [f"left alone: {fault}" for fault in dict.fromkeys((*alone, *motions.faults))]
    place = pathlib.Path(out) if out else source.with_name(f"{source.stem}_compensated")
    files = _files(texts, codec, place, chosen)
    put_files(files, keep)
    return Corrected(done, tuple(files), len(edits), shared, tuple(notes), read)


def _without_singular(robot: Robot, targets: list[Target], q: Array) -> tuple[list[int], list[Fault]]:
    """Which targets are left without the joint targets (at home, mostly) where the arm is near-singular: a
    correction there takes joints far, and nothing is drawn. q: (M, 6) the joints at all."""
    arm, tip = rigid(arrays(robot), np.eye(4), ranges_of(robot))
    found = {trouble.index for trouble in near_singular(arm, tip, tip.jacobian(arm, frames_at(arm, q)))}
    left = [i for i in sorted(found) if targets[i].X is None]
    kept = [i for i in range(len(targets)) if i not in left]
    if not left or not kept:
        return list(range(len(targets))), []
    what = "a joint target where the arm is near-singular"
    return kept, [Fault(targets[i].move.place, what) for i in left]


def _carrying(
    robot: Robot, frames: Frames, moves: Sequence[Move], conditions: Conditions
) -> tuple[Conditions, list[str]]:
    """With what the program says that the arm carries, where no payload was named and it is no less than the
    tool of the model; a remark where that is something else. Raises `InputError` where it says several."""
    loads = [frames.load(move.load) for move in moves if move.load is not None]
    every = [load for i, load in enumerate(loads) if not any(alike(load, other) for other in loads[:i])]
    unnamed, tool = conditions.payload == robot.mounted, conditions.tool_mass
    if robot.mounted and unnamed:
        tool += conditions.payload_mass
    if not every and robot.payloads and unnamed:
        known = ", ".join(robot.payloads)
        taken = robot.mounted or "no payload"
        return conditions, [f"taken to carry {taken}; the model knows {known} (--payload NAME)"]
    if not every or (len(every) == 1 and alike(every[0], carried(conditions))):
        return conditions, []
    said = ", then ".join(_weighs(load) for load in every)
    if not unnamed or max(load.mass_kg for load in every) < tool:
        taken = "the tool of the model" if unnamed else f"payload {conditions.payload!r}"
        return conditions, [f"the program says that the arm carries {said}; taken: {taken}"]
    if len(every) > 1:
        what = f"the program says that the arm carries {said}"
        raise InputError(Fault(moves[0].place, what, "split it, or say what counts with --payload NAME"))
    for name in robot.payloads:
        felt = {what: getattr(conditions, what) for what in ("wrench", "temperature", "clock")}
        named = replace(stated_conditions(robot, name), **felt)
        if alike(every[0], carried(named)):
            return named, [f"the arm carries {name!r}, as the program says ({said})"]
    (load,) = every
    com = [1e-3 * value for value in load.com_mm]
    return replace(conditions, payload="", payload_mass=0.0, tool_mass=load.mass_kg, tool_com=com), [
        f"the arm carries {said}: the program says so"
    ]


def _weighs(load: LoadData) -> str:
    x, y, z = load.com_mm
    return f"{load.mass_kg:g} kg at {x:.0f}, {y:.0f}, {z:.0f} mm" if load.mass_kg else "nothing"


def _tools(frames: Frames, targets: Sequence[Target]) -> list[Array]:
    """(4, 4) of each target in the flange's frame; joint targets, which need none, have the next one's."""
    found, tool = list[Array](), None
    for target in reversed(targets):
        if tool is None or target.X is not None:
            tool = frames.tool_of(target.move)
        found.append(tool)
    return found[::-1]


def _at_own_tools(
    runs: Sequence[Compensation], of: NDArray[np.intp], targets: Sequence[Target]
) -> Compensation:
    """Of the runs of all targets with each tool (`of`: (M,) whose tool is a target's) every target's own; on
    the way to a target it is that target's tool that runs straight."""

    def chosen(name: str, which: NDArray[np.intp]) -> Array:
        return np.stack([getattr(run, name) for run in runs])[which, np.arange(len(which))]

    rows = ("X_desired", "q_command", "X_command", "before", "after")
    straight = [_straight(target) for target in targets[1:]]
    taken = {name: chosen(name, of) for name in rows}
    return replace(runs[of[0]], **taken, between=np.where(straight, chosen("between", of[1:]), 0.0))


def _as_written(robot: Robot, frames: Frames, targets: Sequence[Target], q: Array) -> Array:
    """(M, 6) joints at targets that were written, digits and all; q: (M, 6) those that were asked for."""
    arm, tip = rigid(arrays(robot), np.eye(4), ranges_of(robot))
    out = q.copy()
    poses = [i for i, target in enumerate(targets) if target.X is not None]
    for i, target in enumerate(targets):
        if target.X is None:
            out[i] = frames.joints(target.move.arm)
    if poses:
        X = np.array([frames.flange(targets[i].move, X) for i in poses if (X := targets[i].X) is not None])
        out[poses] = newton(arm, tip, X, q[poses])[0]
    return out


def _straight(target: Target) -> bool:
    """Whether the way to a target is the program's matter, and not the joints'."""
    return target.X is not None and not target.move.free


def _by_extension(source: pathlib.Path) -> Format:
    found = [format for format in formats().values() if source.suffix.lower() in format.extensions]
    if not found:
        known = ", ".join(sorted(format.extension for format in formats().values()))
        raise InputError(Fault(str(source), f"no format ends in {source.suffix!r}", f"known: {known}"))
    return found[0]


def _texts(source: pathlib.Path) -> tuple[dict[str, str], str]:
    """The program's files as they are, line ends included, and their encoding: UTF-8, or else Latin-1."""
    try:
        data = {one.name: one.read_bytes() for one in (source, *beside(source))}
    except OSError as error:
        raise InputError(Fault(str(source), error.strerror or "cannot be read", "check the path")) from None
    for codec in ("utf-8", "latin-1"):
        try:
            return {name: content.decode(codec) for name, content in data.items()}, codec
        except UnicodeDecodeError:
            continue
    raise AssertionError("Latin-1 decodes every byte")


def _edits(
    format: Format,
    texts: Mapping[str, str],
    frames: Frames,
    targets: Sequence[Target],
    done: Compensation,
) -> tuple[dict[Spot, list[str]], list[int]]:
    """The new numbers of every target, and which targets were used before, where other numbers are right."""
    edits: dict[Spot, list[str]] = {}
    again: list[int] = []
    for i, (target, q, X) in enumerate(zip(targets, done.q_command, done.X_command, strict=True)):
        old = target.spot.old(texts[target.spot.file])
        if target.X is None:
            new, digits = format.joint_numbers(frames.shown(q)), _digits(format, joints=True)
        else:
            new = format.numbers(frames.in_base(target.move, X), np.array([float(text) for text in old]))
            digits = _digits(format, joints=False)
        numbers = [_like(text, value, k) for text, value, k in zip(old, new, digits, strict=False)]
        if edits.setdefault(target.spot, numbers) != numbers:
            again.append(i)
    return edits, again


def _shared(
    targets: Sequence[Target], again: Sequence[int], asked: Compensation, done: Compensation
) -> tuple[int, list[str]]:
    """How many targets are used `again` where another correction is right, and a note on each use."""
    spots, notes = set[Spot](), list[str]()
    for i in again:
        apart = 1e3 * float(np.linalg.norm(done.X_command[i, :3, 3] - asked.X_command[i, :3, 3]))
        if apart > SAME_MM:
            spots.add(targets[i].spot)
            notes.append(
                f"{targets[i].move.place}: this target is used before, where its correction differs by "
                f"{apart:.2g} mm; the first one counts"
            )
    return len(spots), list(dict.fromkeys(notes))


def _digits(format: Format, joints: bool) -> list[int]:
    """Decimals that the format writes for each number of a target."""
    place, turn = format.decimals()
    joint = format.joint_decimals()
    return [joint] * 6 if joints else [place] * 3 + [turn] * 4


def _like(old: str, value: float, digits: int) -> str:
    """The number with as many decimals as the old one, or the format's where these are more."""
    fraction = old.lower().split("e")[0].partition(".")[2]
    return f"{value:z.{max(len(fraction), digits)}f}"


def _changed(texts: Mapping[str, str], edits: Mapping[Spot, list[str]]) -> dict[str, str]:
    """The files' texts with the new numbers in the old ones' places."""
    found = {}
    for name, text in texts.items():
        changes = [
            change for spot, numbers in edits.items() if spot.file == name for change in spot.changes(numbers)
        ]
        for (start, end), new in sorted(changes, reverse=True):
            text = text[:start] + new + text[end:]
        found[name] = text
    return found


def _files(
    texts: Mapping[str, str], codec: str, out: pathlib.Path, format: Format
) -> dict[pathlib.Path, bytes]:
    """The texts as files at their places."""
    single, files = not is_folder(out, format), {}
    for i, (name, text) in enumerate(texts.items()):
        place = out / name
        if single:
            alike = pathlib.Path(name).suffix.lower() in NAMED_ALIKE
            place = (
                out if i == 0 else out.with_suffix(pathlib.Path(name).suffix) if alike else out.parent / name
            )
        files[place] = text.encode(codec)
    return files
