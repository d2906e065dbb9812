"""ROS packages without ROS: where `package://name/...` and `$(find name)` are."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from pathlib import Path
from urllib.parse import unquote

from ..files.faults import Fault, InputError

MANIFEST = "package.xml"
UPWARDS = 6  # folders above the URDF in which its package and those beside it are looked for
WORKSPACE = 4  # folders above the URDF up to that of all repositories: .../ROBOT/urdf/TYPE in each
DOWNWARDS = 3  # folders below an entry of ROS_PACKAGE_PATH
Given = Mapping[str, Path]
Find = Callable[[str], Path | None]


def given_packages(texts: list[str]) -> dict[str, Path]:
    """Folders from NAME=DIR. Raises `InputError`."""
    folders = {}
    for text in texts:
        name, equals, folder = text.partition("=")
        if not (name and equals and Path(folder).is_dir()):
            what = f"{text!r} is no NAME=DIR" if not (name and equals) else f"no folder {folder!r}"
            raise InputError(Fault("--package", what, "like ur_description=/opt/ur_description"))
        folders[name] = Path(folder).resolve()
    return folders


def package_folder(name: str, beside: Path, given: Given | None = None) -> Path | None:
    """The folder of a package, None where it is not found.

    Looked for as `given`; upwards from the folder `beside` and in the folders next to those on the way; in
    ROS_PACKAGE_PATH; in the `share` of AMENT_PREFIX_PATH; inside of the folders next to those on the way, as
    repositories of one workspace have it. A folder is the package that its package.xml says, else the one
    that it is called.
    """
    if given and name in given:
        return given[name]
    for folder in _around(beside.resolve()):
        if _package_name(folder) == name:
            return folder
    for prefix in _entries("AMENT_PREFIX_PATH"):
        if (folder := prefix / "share" / name).is_dir():
            return folder
    for root in _entries("ROS_PACKAGE_PATH"):
        for folder in _down(root, DOWNWARDS):
            if _package_name(folder) == name:
                return folder
    for folder in _neighbours(beside.resolve()):
        if _package_name(folder) == name:
            return folder
    return next((folder for folder in _around(beside.resolve()) if folder.name == name), None)


def finder(beside: Path, given: Given | None = None) -> Find:
    """`package_folder` from there, for one file: each package is looked for once, among many folders."""
    return cache(partial(package_folder, beside=beside, given=given))


def mesh_file(uri: str, beside: Path, find: Find) -> Path | None:
    """The file that a mesh's filename in a URDF in the folder `beside` names; None where there is none."""
    scheme, colon, rest = uri.partition("://")
    path = beside / uri
    if colon:
        path = Path("/" + unquote(rest).lstrip("/"))
        name, inside = in_package(uri)
        if name and not (scheme == "file" and path.is_file()):
            folder = find(name)
            return folder / inside if folder is not None and (folder / inside).is_file() else None
        if scheme != "file":
            return None
    return path if path.is_file() else None


def in_package(uri: str) -> tuple[str, str]:
    """Name of the package and the file in it, of `package://NAME/FILE` and of `file:///.../share/NAME/FILE`,
    where a package is installed on the machine that expanded the URDF; "" where there is none."""
    scheme, _, rest = unquote(uri).partition("://")
    if scheme == "file":
        rest = rest.partition("/share/")[2]
    elif scheme not in ("package", "model"):
        rest = ""
    name, _, inside = rest.partition("/")
    return name, inside


def _entries(variable: str) -> list[Path]:
    folders = [Path(text) for text in os.environ.get(variable, "").split(os.pathsep) if text]
    return [folder for folder in folders if folder.is_dir()]


def _around(folder: Path) -> Iterator[Path]:
    """The folder, those above, and beside each of these those next to it."""
    above = [folder, *folder.parents][: UPWARDS + 1]
    yield from above
    for place in above[1:]:
        yield from _inside(place)


def _neighbours(folder: Path) -> Iterator[Path]:
    """What is inside of the folders next to it and to those above, up to the repositories of a workspace."""
    for place in [*folder.parents][:WORKSPACE]:
        if place != place.parent:
            for inner in _inside(place):
                yield from _inside(inner)


def _down(folder: Path, depth: int) -> Iterator[Path]:
    yield folder
    if depth and not (folder / MANIFEST).is_file():
        for inner in _inside(folder):
            yield from _down(inner, depth - 1)


def _inside(folder: Path) -> list[Path]:
    try:
        return sorted(Path(item.path) for item in os.scandir(folder) if item.is_dir())
    except OSError:
        return []


@cache
def _package_name(folder: Path) -> str | None:
    """What the folder's package.xml says that it is called; None without one."""
    try:
        return (ET.parse(folder / MANIFEST).getroot().findtext("name") or "").strip() or None
    except (OSError, ET.ParseError):
        return None
