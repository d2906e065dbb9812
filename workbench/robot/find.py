"""Robots by name, among those that come with the workbench, or by the path of a TOML."""

from __future__ import annotations

from pathlib import Path

from ..files.faults import Fault, InputError


def model_folders() -> list[Path]:
    """Where robots that come with the workbench are looked for."""
    package = Path(__file__).resolve().parents[1]
    return [folder for folder in (package.parent / "models", package / "models") if folder.is_dir()]


def list_robots() -> list[Path]:
    """The TOML of every robot that comes with the workbench, sorted by name."""
    found = {path.stem: path for folder in model_folders() for path in folder.glob("*/*.toml")}
    return [found[name] for name in sorted(found)]


def find_robot(robot: str | Path, beside: Path | None = None) -> Path:
    """Path of a robot's TOML from a name under `models/` or a path (relative to `beside`).

    Raises `InputError` when there is none.
    """
    text = str(robot)
    if not text.endswith(".toml"):
        for path in list_robots():
            if path.stem == text:
                return path
        known = ", ".join(path.stem for path in list_robots())
        if text.lower().endswith((".urdf", ".xacro")):
            mend = "name a robot TOML that has it as `urdf`: `workbench init` writes one"
            raise InputError(Fault(text, "is a robot's description, not the robot's TOML", mend))
        raise InputError(Fault(text, "no such robot", f"known: {known}; or give the path of a robot TOML"))
    path = Path(text)
    if not path.is_absolute() and beside is not None:
        path = beside / path
    if not path.is_file():
        mend = "check the path" if beside is None else "check `robot = ...`"
        raise InputError(Fault(str(path), "no such robot file", mend))
    return path
