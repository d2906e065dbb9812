"""A robot's URDF for Drake: bare for arithmetic, with pictures for scenes."""

from __future__ import annotations

import tempfile
from functools import lru_cache
from pathlib import Path

from .chain import read_chain
from .description import Robot
from .meshes import mesh_files, mesh_notes, pictures
from .plain_urdf import left_out, plain_text
from .urdf import read_urdf


def bare_text(robot: Robot) -> str:
    """Links, joints and masses from the base on, without anything to look at."""
    return _bare(robot.urdf, robot.flange, robot.base, robot.urdf.stat().st_mtime_ns)


@lru_cache(maxsize=8)
def _bare(path: Path, flange: str, base: str, _changed: int) -> str:
    urdf = read_urdf(path)
    return plain_text(urdf, read_chain(urdf, flange, base))


def shown_text(robot: Robot) -> str:
    """The same with visuals; meshes that Drake cannot show are converted once in a process."""
    return _shown(robot.urdf.resolve(), robot.flange, robot.base, robot.urdf.stat().st_mtime_ns)


@lru_cache(maxsize=8)
def _shown(path: Path, flange: str, base: str, _changed: int) -> str:
    urdf = read_urdf(path)
    chain = read_chain(urdf, flange, base)
    folder = Path(tempfile.mkdtemp(dir=_scratch().name))
    return plain_text(urdf, chain, pictures(mesh_files(urdf, chain), folder))


@lru_cache(maxsize=1)
def _scratch() -> tempfile.TemporaryDirectory[str]:
    """A folder that goes with the process."""
    return tempfile.TemporaryDirectory(prefix="workbench-meshes-")


def urdf_notes(robot: Robot) -> list[str]:
    """What of the URDF does not count, or cannot be shown: a line each."""
    urdf = read_urdf(robot.urdf)
    chain = read_chain(urdf, robot.flange, robot.base)
    notes = [*mesh_notes(mesh_files(urdf, chain)), *left_out(urdf, chain)]
    return [f"{robot.urdf}: {note}" for note in notes]
