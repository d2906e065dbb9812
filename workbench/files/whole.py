"""Files appear whole or not at all; those of one result all together or none of them."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from pathlib import Path


def put(path: Path, data: bytes | str) -> None:
    """Write one file, whole or not at all; see `put_all`."""
    put_all({path: data})


def put_all(files: Mapping[Path, bytes | str]) -> None:
    """Write the files of one result: all of them, or none when one fails.

    Text becomes UTF-8 with its line ends as they are; folders that lack are made. Every file is first
    written beside its place, then all are moved there in the order given. On a failure the files that stood
    there before stand there again, and neither temporary files nor new folders are left.
    """
    with ExitStack() as new_folders, ExitStack() as temporary, ExitStack() as placed:
        fresh, kept = {}, {}
        for path, data in files.items():
            _make_folder(path.parent, new_folders)
            fresh[path] = _beside(path, temporary)
            fresh[path].write_bytes(data.encode() if isinstance(data, str) else data)
            kept[path] = _copied(path, temporary)
        for path, source in fresh.items():
            placed.callback(_take_back, path, kept[path])
            os.replace(source, path)
        placed.pop_all()
        new_folders.pop_all()


def _make_folder(folder: Path, made: ExitStack) -> None:
    """Make a folder and what lacks above it; `made` takes them away again, the deepest first."""
    for place in [*reversed(folder.parents), folder]:
        if not place.exists():
            place.mkdir(exist_ok=True)
            made.callback(_remove_empty, place)


def _remove_empty(folder: Path) -> None:
    with suppress(OSError):  # somebody else has put a file there meanwhile
        folder.rmdir()


def _beside(path: Path, temporary: ExitStack) -> Path:
    """A name in the same folder, so that moving is one step; short, whatever the length of the file's own."""
    name = path.with_name(f".{secrets.token_hex(8)}.part")
    temporary.callback(name.unlink, missing_ok=True)
    return name


def _copied(path: Path, temporary: ExitStack) -> Path | None:
    """A copy of what stands at `path`; None where nothing does."""
    if not os.path.lexists(path):
        return None
    copy = _beside(path, temporary)
    shutil.copy2(path, copy, follow_symlinks=False)
    return copy


def _take_back(path: Path, kept: Path | None) -> None:
    if kept is None:
        path.unlink(missing_ok=True)
    else:
        os.replace(kept, path)
