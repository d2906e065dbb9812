"""An existing robot program with its targets corrected, and everything else in it untouched byte for byte."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..files.digest import digests
from ..files.faults import Fault, InputError
from ..robot.description import load_robot
from ..robot.kinematics import Array
from .command import Compensation, compensate
from .conditions import Conditions
from .paths import Path
from .program_postures import joints_at
from .program_targets import Frames, Target, targets_of, times_of
from .programs import Format, find_format, formats
from .programs.files import beside, is_folder, put_files
from .programs.motions import Spot

NAMED_ALIKE = (".dat",)  # belongs to a program by its name
SAME_MM = 1e-3  # corrections of one target that differ by less are the same


@dataclass(frozen=True, eq=False)
class Corrected:
    """A corrected program on disk: how many targets, how far they were moved, and what was left alone.
    inputs: "<folder>/<file>" → SHA-256."""

    compensation: Compensation
    files: tuple[pathlib.Path, ...]
    targets: int
    notes: tuple[str, ...]
    inputs: Mapping[str, str]

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
            "between_max_mm": self.compensation.between_mm,
            "notes": list(self.notes),
            "inputs": dict(self.inputs),
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
    start: Array | None = None,
    as_urdf: bool = False,
    keep: bool = False,
) -> Corrected:
    """Corrects the targets of a KRL, RAPID, VAL 3, LS or URScript program for the model's robot, only these.

    out: a folder (default: NAME_compensated beside the program) or a file with the same extension. tool and
    base: (4, 4) where the program's own stand on the controller, not in the file. start: (6,) the URDF's
    joints [rad] before the first target, where the file does not say the posture. Between targets the arm
    moves as before: what depends on the joints in between is corrected at the targets only. Raises
    `InputError`; nothing is written then.
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
    frames.check(moves, motions.unknown)
    targets = targets_of(moves)
    if len(targets) == 1:
        targets *= 2  # a path has two samples at least
    q, postures = joints_at(robot, frames, targets, start)
    lines = tuple(target.move.line for target in targets)
    told = Path(times_of(targets), q=q, title=source.stem, file=source.name, lines=lines)
    done = compensate(robot, told, conditions)
    done = replace(done, between=np.where([_straight(target) for target in targets[1:]], done.between, 0.0))
    edits, notes = _edits(chosen, texts, frames, targets, done)
    notes += postures
    notes += [f"left alone: {fault}" for fault in motions.faults]
    place = pathlib.Path(out) if out else source.with_name(f"{source.stem}_compensated")
    files = _written(texts, edits, codec, place, chosen)
    put_files(files, keep)
    return Corrected(done, tuple(files), len(edits), tuple(notes), read)


def _straight(target: Target) -> bool:
    """Whether the way to a target is the program's matter, and not the joints'."""
    return target.X is not None and not target.move.free


def _by_extension(source: pathlib.Path) -> Format:
    found = [format for format in formats().values() if format.extension == source.suffix.lower()]
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
) -> tuple[dict[Spot, list[str]], list[str]]:
    """The new numbers of every target, and notes on those that are used in several ways."""
    edits: dict[Spot, list[str]] = {}
    first: dict[Spot, Array] = {}
    notes: list[str] = []
    for target, q, X in zip(targets, done.q_command, done.X_command, strict=True):
        old = target.spot.old(texts[target.spot.file])
        if target.X is None:
            new, digits = format.joint_numbers(frames.shown(q)), _digits(format, joints=True)
        else:
            new = format.numbers(frames.target(target.move, X), np.array([float(text) for text in old]))
            digits = _digits(format, joints=False)
        if target.spot not in edits:
            edits[target.spot] = [
                _like(text, value, k) for text, value, k in zip(old, new, digits, strict=False)
            ]
            first[target.spot] = X
        elif (apart := 1e3 * float(np.linalg.norm(X[:3, 3] - first[target.spot][:3, 3]))) > SAME_MM:
            notes.append(
                f"{target.move.place}: this target is used before, where its correction differs by "
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
            change for spot, numbers in edits.items() if spot.file == name for change in spot.changes(numbers)
        ]
        for (start, end), new in sorted(changes, reverse=True):
            text = text[:start] + new + text[end:]
        place = out / name
        if single:
            alike = pathlib.Path(name).suffix.lower() in NAMED_ALIKE
            place = (
                out if i == 0 else out.with_suffix(pathlib.Path(name).suffix) if alike else out.parent / name
            )
        files[place] = text.encode(codec)
    return files
