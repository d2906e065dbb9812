"""An existing robot program with its targets corrected, and everything else in it untouched byte for byte."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..files.faults import Fault, InputError
from ..robot import rotations
from ..robot.description import Robot, load_robot
from ..robot.kinematics import Array
from .command import Compensation, compensate
from .conditions import Conditions
from .paths import Path
from .programs import Format, find_format, formats
from .programs.files import is_folder, put_files
from .programs.motions import Move, Spot
from .programs.shown import stated_convention
from .trajectory import nominal_joints

STEP, TURN = 0.02, np.radians(5)  # m and rad between the samples that follow the arm from target to target
SECOND = 1.0  # a leg that does not say how long it takes
BESIDE = {".src": ".dat"}
SAME_MM = 1e-3  # corrections of one target that differ by less are the same


@dataclass(frozen=True, eq=False)
class Corrected:
    """A corrected program on disk: how many targets, how far they were moved, and what was left alone."""

    compensation: Compensation
    files: tuple[pathlib.Path, ...]
    targets: int
    notes: tuple[str, ...]

    def lines(self) -> list[str]:
        """What a user should know, a line each."""
        return [f"{self.targets} targets corrected", *self.compensation.lines(), *self.notes]

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
            "before_max_mm": float(before.max()),
            "after_max_mm": float(after.max()),
            "notes": list(self.notes),
        }


def is_program(path: pathlib.Path) -> bool:
    """Whether the file is a controller's program, by its extension."""
    own = {format.extension for format in formats().values() if not format.samples}
    return path.suffix.lower() in own


def compensate_program(
    path: str | pathlib.Path,
    model: str | pathlib.Path,
    out: str | pathlib.Path | None = None,
    *,
    format: str | None = None,
    conditions: Conditions | None = None,
    tool: Array | None = None,
    base: Array | None = None,
    as_urdf: bool = False,
    keep: bool = False,
) -> Corrected:
    """Corrects the targets of a KRL, RAPID, LS or URScript program for the model's robot, and nothing else.

    out: a folder (default: NAME_compensated beside the program) or a file with the same extension. tool, base:
    (4, 4) where the program's own stand on the controller, not in the file. Between targets the controller
    moves as before: what depends on the joints in between is corrected at the targets only. Raises
    `InputError`; nothing is written then.
    """
    source, robot = pathlib.Path(path), load_robot(model)
    chosen = find_format(format) if format else _by_extension(source)
    texts, codec = _texts(source)
    motions = chosen.scan(texts)
    moves = [move for move in motions.moves if move.spot is not None]
    if not moves:
        raise InputError(motions.faults or [Fault(str(source), "has no target that could be corrected")])
    frames = _Frames(robot, as_urdf, tool, base)
    frames.check(moves, motions.unknown)
    samples = _samples(moves)
    if len(samples) == 1:
        samples *= 2  # a path has two samples at least
    q = _joints(robot, frames, samples)
    lines = tuple(sample.move.line for sample in samples)
    told = Path(_times(samples), q=q, title=source.stem, file=source.name, lines=lines)
    done = compensate(robot, told, conditions)
    edits, notes = _edits(chosen, texts, frames, samples, done)
    notes += [f"left alone: {fault}" for fault in motions.faults]
    place = pathlib.Path(out) if out else source.with_name(f"{source.stem}_compensated")
    files = _written(texts, edits, codec, place, chosen)
    put_files(files, keep)
    return Corrected(done, tuple(files), len(edits), tuple(notes))


def _by_extension(source: pathlib.Path) -> Format:
    found = [format for format in formats().values() if format.extension == source.suffix.lower()]
    if not found:
        known = ", ".join(sorted(format.extension for format in formats().values()))
        raise InputError(Fault(str(source), f"no format ends in {source.suffix!r}", f"known: {known}"))
    return found[0]


def _texts(source: pathlib.Path) -> tuple[dict[str, str], str]:
    """The program's files as they are, line ends included, and their encoding: UTF-8, or else Latin-1."""
    names, wanted = [source], BESIDE.get(source.suffix.lower())
    if wanted and source.parent.is_dir():
        names += [other for other in sorted(source.parent.iterdir())
                  if other.name.lower() == f"{source.stem}{wanted}".lower()]  # fmt: skip
    try:
        data = {name.name: name.read_bytes() for name in names}
    except OSError as error:
        raise InputError(Fault(str(source), error.strerror or "cannot be read", "check the path")) from None
    for codec in ("utf-8", "latin-1"):
        try:
            return {name: content.decode(codec) for name, content in data.items()}, codec
        except UnicodeDecodeError:
            continue
    raise AssertionError("Latin-1 decodes every byte")


class _Frames:
    """From the program's numbers to the URDF's joints and flange, and back."""

    def __init__(self, robot: Robot, as_urdf: bool, tool: Array | None, base: Array | None) -> None:
        self.robot, self.tool, self.base = robot, tool, base
        self.convention = None if as_urdf else stated_convention(robot)

    def check(self, moves: Sequence[Move], unknown: Mapping[str, str]) -> None:
        """Six turning joints, no rails, and all frames known."""
        faults = []
        if len(self.robot.joints) != 6 or any(joint.kind == "prismatic" for joint in self.robot.joints):
            what = "has not six turning joints: its programs are not corrected in place"
            faults.append(Fault(self.robot.name, what, "export the path anew"))
        faults += [
            Fault(move.place, "has external axes", "export the path anew") for move in moves[:1] if move.rails
        ]
        for name, given in (("tool", self.tool), ("base", self.base)):
            if given is None and any(getattr(m, name) is None for m in moves if m.kind == "pose"):
                what = f"this {name} stands on the controller, not in the file"
                faults.append(Fault(unknown[name], what, f"give it with --{name} X,Y,Z,A,B,C"))
        if faults:
            raise InputError(faults)

    def joints(self, arm: Sequence[float]) -> Array:
        """(6,) the URDF's joints."""
        q = np.array([arm])
        return np.asarray((self.convention.joints(q) if self.convention else q)[0])

    def shown(self, q: Array) -> Array:
        """(6,) the controller's joints."""
        return np.asarray((self.convention.shown(q[None]) if self.convention else q[None])[0])

    def flange(self, move: Move, X: Array) -> Array:
        """(4, 4) the URDF's flange in its base, of a target in the move's base."""
        return self._base(move) @ X @ np.linalg.inv(self._tool(move))

    def target(self, move: Move, flange: Array) -> Array:
        """(4, 4) the target in the move's base, of the URDF's flange in its base."""
        return np.asarray(np.linalg.inv(self._base(move)) @ flange @ self._tool(move))

    def _base(self, move: Move) -> Array:
        base = move.base if move.base is not None else self.base
        assert base is not None
        return base if self.convention is None else self.convention.from_world(base)

    def _tool(self, move: Move) -> Array:
        tool = move.tool if move.tool is not None else self.tool
        assert tool is not None
        return tool if self.convention is None else self.convention.from_flange(tool)


@dataclass(frozen=True, eq=False)
class _Sample:
    """A target of a move: its end, or the point over which its circle goes."""

    move: Move
    X: Array | None
    spot: Spot
    last: bool


def _samples(moves: Sequence[Move]) -> list[_Sample]:
    found = []
    for move in moves:
        assert move.spot is not None
        if move.via is not None and move.via_spot is not None:
            found.append(_Sample(move, move.via, move.via_spot, False))
        found.append(_Sample(move, move.X, move.spot, True))
    return found


def _times(samples: Sequence[_Sample]) -> Array:
    """(M,) when the arm is there [s]."""
    legs = []
    for sample in samples:
        duration = sample.move.duration
        whole = duration if duration > 0 else SECOND
        legs.append(whole / 2 if sample.move.via is not None else whole)
    return np.cumsum(legs)


def _joints(robot: Robot, frames: _Frames, samples: Sequence[_Sample]) -> Array:
    """(M, 6) the URDF's joints at every target, straight legs followed from the joints before them."""
    q: list[Array] = []
    run: list[_Sample] = []

    def follow() -> None:
        """The poses collected so far, from the last joints known."""
        if run:
            X = np.array([frames.flange(sample.move, _pose(sample)) for sample in run])
            dense, at = _between(X)
            dense = (
                dense if len(dense) > 1 else np.repeat(dense, 2, axis=0)
            )  # a path has two samples at least
            ends = np.minimum(np.searchsorted(at, np.arange(len(dense))), len(run) - 1)
            lines = tuple(run[i].move.line for i in ends)
            file = run[0].move.place.split(" line ")[0]
            told = Path(np.arange(float(len(dense))), X=dense, file=file, lines=lines)
            q.extend(nominal_joints(robot, told, start=q[-1] if q else None)[at])
            run.clear()

    for sample in samples:
        if sample.X is None:
            follow()
            q.append(frames.joints(sample.move.arm))
            continue
        if np.isfinite(sample.move.share):  # moves freely: not along a line from the pose before
            follow()
        run.append(sample)
    follow()
    return np.array(q)


def _pose(sample: _Sample) -> Array:
    assert sample.X is not None
    return sample.X


def _between(X: Array) -> tuple[Array, Array]:
    """Poses (K, 4, 4) with steps of `STEP` and `TURN` between them, and where the given ones stand."""
    poses, at = [X[:1]], [0]
    for start, end in zip(X[:-1], X[1:], strict=True):
        whole = rotations.vectors(start[None, :3, :3].transpose(0, 2, 1) @ end[None, :3, :3])
        way = end[:3, 3] - start[:3, 3]
        count = int(max(np.linalg.norm(way) / STEP, np.linalg.norm(whole) / TURN)) + 1
        share = np.linspace(0, 1, count + 1)[1:, None]
        turn = start[:3, :3] @ rotations.from_vectors(share * whole)
        poses.append(rotations.pose(start[:3, 3] + share * way, turn))
        at.append(at[-1] + count)
    return np.concatenate(poses), np.array(at)


def _edits(
    format: Format,
    texts: Mapping[str, str],
    frames: _Frames,
    samples: Sequence[_Sample],
    done: Compensation,
) -> tuple[dict[Spot, list[str]], list[str]]:
    """The new numbers of every target, and notes on those that are used in several ways."""
    edits: dict[Spot, list[str]] = {}
    first: dict[Spot, Array] = {}
    notes: list[str] = []
    for sample, q, X in zip(samples, done.q_command, done.X_command, strict=True):
        old = [texts[sample.spot.file][a:b] for a, b in sample.spot.spans]
        if sample.X is None:
            new, digits = format.joint_numbers(frames.shown(q)), _digits(format, joints=True)
        else:
            new = format.numbers(frames.target(sample.move, X), np.array([float(text) for text in old]))
            digits = _digits(format, joints=False)
        if sample.spot not in edits:
            edits[sample.spot] = [
                _like(text, value, k) for text, value, k in zip(old, new, digits, strict=False)
            ]
            first[sample.spot] = X
        elif (apart := 1e3 * float(np.linalg.norm(X[:3, 3] - first[sample.spot][:3, 3]))) > SAME_MM:
            notes.append(
                f"{sample.move.place}: this target is used before, where its correction differs by "
                f"{apart:.2g} mm; the first one counts"
            )
    return edits, notes


def _digits(format: Format, joints: bool) -> list[int]:
    """Decimals that the format writes for each number of a target."""
    place, turn = format.decimals()
    joint = format.joint_decimals()
    return [joint] * 6 if joints else [place] * 3 + [turn] * 4


def _like(old: str, value: float, digits: int) -> str:
    """The number with as many decimals as the old one, or the format's where these are more."""
    fraction = old.lower().split("e")[0].partition(".")[2]
    return f"{value:z.{max(len(fraction), digits)}f}"


def _written(
    texts: Mapping[str, str], edits: Mapping[Spot, list[str]], codec: str, out: pathlib.Path, format: Format
) -> dict[pathlib.Path, bytes]:
    """The files with the new numbers in the old ones' places."""
    single, files = not is_folder(out, format), {}
    for i, (name, text) in enumerate(texts.items()):
        changes = [
            (span, new)
            for spot, numbers in edits.items()
            if spot.file == name
            for span, new in zip(spot.spans, numbers, strict=True)
        ]
        for (start, end), new in sorted(changes, reverse=True):
            text = text[:start] + new + text[end:]
        place = out / name
        if single:
            place = out if i == 0 else out.with_suffix(pathlib.Path(name).suffix)
        files[place] = text.encode(codec)
    return files
