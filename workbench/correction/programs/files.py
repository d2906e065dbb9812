"""Programs to disk, and what the rounding of their numbers does at the tool."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from ...files.faults import Fault, InputError
from ...files.whole import put_all
from ...robot import rotations
from .base import Array, Program
from .catalogue import formats
from .format import Format

log = logging.getLogger(__name__)
LEAST_MM = 1e-3  # below that no number is said: no robot and no instrument knows it
PIECE = 10_000  # samples of a table


@dataclass(frozen=True)
class RoundingEffect:
    """How far the written numbers put the tool from the program's own: mm, and the turn in degrees."""

    mean_mm: float
    max_mm: float
    max_deg: float

    def __str__(self) -> str:
        if self.max_mm < LEAST_MM:
            return f"rounding moves the tool by less than {LEAST_MM:g} mm"
        return f"rounding moves the tool by {self.mean_mm:.2g} mm (mean), {self.max_mm:.2g} mm (most)"


def rounding_effect(
    program: Program,
    format: Format,
    forward: Callable[[Array], Array] | None = None,
) -> RoundingEffect:
    """Writes the program, reads it back and compares, at the tool.

    forward: (N, n) joints → (N, 4, 4) tool poses; needed for a program of joints.
    The tool's own frame is rounded too: what the controller does is X̃ T̃⁻¹ T.
    """
    off, turned = zip(*(_rounded(piece, format, forward) for piece in _pieces(program, format)), strict=True)
    error, angle = np.concatenate(off), np.concatenate(turned)
    return RoundingEffect(1e3 * float(error.mean()), 1e3 * float(error.max()), float(np.degrees(angle.max())))


def _pieces(program: Program, format: Format) -> Iterator[Program]:
    """The program; a table of samples in pieces, since as texts its numbers take far more room."""
    if not format.samples:
        yield program
        return
    for start in range(0, program.count, PIECE):
        some = slice(start, start + PIECE)
        yield replace(
            program,
            X=None if program.X is None else program.X[some],
            q=None if program.q is None else program.q[some],
            time=None if program.time is None else program.time[some],
            dwell=program.dwell[some] if len(program.dwell) > 1 else program.dwell,
        )


def _rounded(
    program: Program, format: Format, forward: Callable[[Array], Array] | None
) -> tuple[Array, Array]:
    """(N,) ways [m] and angles [rad] by which the written numbers are off at the tool."""
    back = format.read(format.write(program))
    if program.kind == "joints":
        if forward is None or program.q is None or back.q is None:
            raise ValueError("a program of joints needs `forward`")
        wanted, given = forward(program.q), forward(back.q)
    else:
        assert program.X is not None
        assert back.X is not None
        tool = back.tool if format.carries_tool else program.tool
        wanted, given = program.X, back.X @ np.linalg.inv(tool) @ program.tool
    way = np.asarray(np.linalg.norm(wanted[:, :3, 3] - given[:, :3, 3], axis=1))
    return way, rotations.angle_between(wanted[:, :3, :3], given[:, :3, :3])


def write_program(program: Program, format: Format, out: Path, keep: bool = False) -> list[Path]:
    """Checks the program and writes its files, all or none; `InputError` and nothing written otherwise.

    out: a file with the format's extension, or a folder, which takes it under the program's own name. A
    format of several files puts the others beside the file. A program without name is named after `out`.
    keep: files that are there with other content stay there, and that is a fault; else a warning in the log
    says what is replaced. Other warnings go to the log too.
    """
    files = program_files(program, format, out)
    put_files(files, keep)
    return list(files)


def program_files(program: Program, format: Format, out: Path) -> dict[Path, bytes]:
    """The files of a program that was checked, by their paths; see `write_program`."""
    text = program.name or format.legal_name(out.stem)
    if not program.name and text.casefold() != out.stem.casefold():
        log.warning("%s: the program is named %r, as %s wants names", out, text, format.title)
    elif program.name and format.named_as_file and not is_folder(out, format) and out.stem != text:
        log.warning("%s: %s wants the file named as the program, %r", out, format.title, text)
    program = replace(program, name=text)
    faults = format.check(program)
    if faults:
        raise InputError(faults)
    for warning in format.warnings(program):
        log.warning("%s: %s", out, warning)
    written = format.write(program).items()
    files = {name: content.replace("\n", format.newline).encode() for name, content in written}
    return _places(files, format, out)


def put_files(files: Mapping[Path, bytes], keep: bool, beside: Mapping[Path, bytes] | None = None) -> None:
    """Writes the files of a program, all or none, and nothing over other content silently; `beside`, which is
    written with them, replaces what is there."""
    other = [path for path, data in files.items() if path.is_file() and path.read_bytes() != data]
    if other and keep:
        what = "is there already, with other content"
        raise InputError(
            [Fault(str(path), what, "name another with --out, or say --force") for path in other]
        )
    for path in other:
        log.warning("%s: replaced", path)
    try:
        put_all({**files, **(beside or {})})
    except OSError as error:
        place = next(iter(files))
        raise InputError(
            Fault(str(place), error.strerror or "cannot be written", "check the folder")
        ) from error


def is_folder(out: Path, format: Format) -> bool:
    """Whether `out` means a folder: it is one, or has no extension. `InputError` for another's extension; a
    table may have any that is no program's."""
    if out.is_dir() or not out.suffix:
        return True
    end = out.suffix.lower()
    other = next((one for one in formats().values() if end in one.extensions), None)
    if end in format.extensions or (format.samples and other is None):
        return False
    what = f"ends in {out.suffix}; {format.title} ends in {format.extension}"
    mend = f"name a folder, or a file ending in {format.extension}"
    raise InputError(Fault(str(out), what, f"{mend}, or say --format {other.name}" if other else mend))


def _places(files: Mapping[str, bytes], format: Format, out: Path) -> dict[Path, bytes]:
    if is_folder(out, format):
        return {out / name: data for name, data in files.items()}
    first, *rest = files
    return {out: files[first]} | {out.parent / name: files[name] for name in rest}


def beside(path: Path) -> list[Path]:
    """The files that belong to a program's file, however their names are spelt (VAL 3: the data and the
    programs of the folder; KRL: its .dat)."""
    patterns = {".pjx": (f"{path.stem}.dtx", "start.pgx", "*.pgx"), ".src": (f"{path.stem}.dat",)}
    wanted = patterns.get(path.suffix.lower(), ())
    if not wanted or not path.parent.is_dir():
        return []
    there = sorted(path.parent.iterdir())
    found = [one for pattern in wanted for one in there if fnmatchcase(one.name.lower(), pattern.lower())]
    return list(dict.fromkeys(found))
