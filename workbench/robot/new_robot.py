"""A robot's own folder out of anybody's URDF: plain URDF, meshes that can be shown, TOML to fill in."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..files.faults import Fault, InputError
from ..files.toml import toml_text
from .chain import Chain, read_chain
from .guess import Guess, guess_flange
from .meshes import mesh_files, mesh_notes, pictures, unreadable
from .packages import Given
from .plain_urdf import left_out, plain_text
from .schema import STANDARD_GRAVITY
from .urdf import parse_urdf, read_xml
from .xacro_files import expanded, is_xacro

MESHES = "meshes"


@dataclass(frozen=True)
class NewRobot:
    """The files of a robot's folder by their place in it; `notes` say what was guessed and left out."""

    name: str
    flange: Guess
    chain: Chain
    files: dict[Path, bytes | str]
    notes: tuple[str, ...]


def new_robot(
    source: Path,
    flange: str | None = None,
    base: str | None = None,
    name: str | None = None,
    arguments: Mapping[str, str] | None = None,
    given: Given | None = None,
) -> NewRobot:
    """A robot from a URDF or a xacro file.

    flange, base: links; None: guessed, the root. arguments: of the xacro file. given: folders of packages.
    Raises `InputError` where the file has no arm, or several and nobody says which, and where there are
    arguments that nothing takes.
    """
    text, read_as = read_xml(source)
    xacro = is_xacro(source, text)
    if arguments and not xacro:
        what = f"is no xacro: nothing in it takes {', '.join(arguments)}"
        raise InputError(Fault(str(source), what, "leave them out, or name the xacro file"))
    if xacro:
        text = expanded(source, text, arguments or {}, given)
    urdf = parse_urdf(text, source, read_as)
    guess = guess_flange(urdf, base) if flange is None else Guess(flange, "as said")
    chain = read_chain(urdf, guess.flange, base)
    if name is not None and not re.fullmatch(r"\w[\w.-]*", name):
        what = f"{name!r} is no name of files"
        raise InputError(Fault("--name", what, "letters, figures, _ and - alone, like kr500"))
    name = name or _name(source, arguments or {})
    meshes = mesh_files(urdf, chain, given)
    with tempfile.TemporaryDirectory(prefix="workbench-") as scratch:
        shown = pictures(meshes, Path(scratch) / MESHES, as_is=False)
        plain = plain_text(urdf, chain, shown, Path(scratch))
        files: dict[Path, bytes | str] = {
            path.relative_to(scratch): path.read_bytes() for path in sorted(Path(scratch).rglob("*.obj"))
        }
    files[Path(f"{name}.urdf")] = plain
    files[Path(f"{name}.toml")] = _toml(name, guess, chain, source)
    notes = [*mesh_notes(meshes), *unreadable(meshes, shown), *left_out(urdf, chain)]
    return NewRobot(name, guess, chain, files, tuple(notes))


def _name(source: Path, arguments: Mapping[str, str]) -> str:
    """Short, of letters that go into file names."""
    stem = arguments.get("name") or re.sub(r"(\.urdf)?(\.xacro)?$", "", source.name)
    return re.sub(r"[^\w-]+", "_", stem).strip("_").lower() or "robot"


def _toml(name: str, guess: Guess, chain: Chain, source: Path) -> str:
    """The robot's TOML: what is known, and as comments what is worth stating."""
    gravity = [round(STANDARD_GRAVITY * value, 9) + 0.0 for value in chain.down]
    head = toml_text({"schema": 1, "name": name, "title": name, "urdf": f"{name}.urdf"})
    lines = [
        "# Made by `workbench init`. Lines that begin with # may be filled in; leave what is not known.",
        head.rstrip(),
        f'flange = "{guess.flange}"   # carries tool and targets; {_mark(guess)}',
        f'base = "{chain.base}"',
        f"gravity = {gravity}   # m/s² on the base's axes; on a wall or a ceiling it is another",
        "# pose_repeatability_mm = 0.05   # ISO 9283 RP, from the maker's data sheet",
    ]
    for joint in chain.joints:
        turns = joint.kind == "revolute"
        stiffness, example = ("N·m/rad, axial", "1.0e6") if turns else ("N/m, axial", "1.0e8")
        ratio = "motor turns per joint turn" if turns else "motor radians per metre"
        tilt = "N·m/rad, of the bearing about the axes across the joint"
        lines += [
            "",
            "[[joints]]",
            f'name = "{joint.name}"',
            f"# stiffness = {example}        # {stiffness}; absent = rigid",
            f"# gear_ratio = 100.0       # {ratio}: gear errors are looked for at its harmonics",
            f"# tilt_stiffness = 1.0e7   # {tilt}",
            "# repeatability = 5e-6     # rad or m, one sigma",
        ]
    count = range(1, len(chain.joints) + 1)
    names, ones, zeros = (
        ", ".join(f'"J{i}"' for i in count),
        ", ".join("1" for _ in count),
        [0.0 for _ in count],
    )
    lines += [
        "",
        "# How its controller counts the joints: programs for it need this. A sign is -1 where it counts the",
        "# other way, a zero is what it shows where the URDF's joint is at 0; all keys: docs/files/robot.md.",
        "# [controller]",
        f"# names = [{names}]",
        f"# signs = [{ones}]",
        f"# zeros = {zeros}",
    ]
    lines += ["", "[source]", *toml_text({"kinematics": source.name}).splitlines()]
    return "\n".join(lines) + "\n"


def _mark(guess: Guess) -> str:
    return guess.why if guess.why == "as said" else f"guessed: {guess.why}"
