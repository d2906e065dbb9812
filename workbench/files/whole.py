"""Files appear whole or not at all; those of one result all together or none of them.

A process that is killed while it moves the files of a result leaves its list of moves: whoever next reads or
writes in that folder carries them out first (`settle`), so that nobody reads half of one result and half of
another. One process at a time writes in a folder. What comes to be file by file, over hours, comes to be
beside the folder of its result (`gathered`).
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import secrets
import shutil
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

MOVES = ".unfinished"  # names of temporary files, and of those that they become
BUSY = ".busy"  # in a temporary folder, locked as long as its process lives
TEMPORARY = re.compile(r"\.[0-9a-f]{16}\.part")


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
        folders = sorted({path.parent for path in files})
        for folder in folders:
            _make_folder(folder, new_folders)
        for folder in folders:
            temporary.enter_context(_locked(folder))
            _clean(folder)
        fresh, kept = {}, {}
        for path, data in files.items():
            fresh[path] = _beside(path, temporary)
            fresh[path].write_bytes(data.encode() if isinstance(data, str) else data)
            kept[path] = _copied(path, temporary)
        if len(files) > 1:
            _list_moves(fresh, temporary)
        for path, source in fresh.items():
            placed.callback(_take_back, path, kept[path])
            os.replace(source, path)
        placed.pop_all()
        new_folders.pop_all()


@contextmanager
def gathered(folder: Path) -> Iterator[Path]:
    """A new folder to make a result in: in the end its files become those of `folder`, all of them or none.

    It stands beside `folder`, as deep as that, so that a path from there to what lies elsewhere is the same;
    or in it, where nobody may write beside it. What else stands in `folder` stays. What a killed process left
    is taken away by whoever next writes there.
    """
    folder = folder.resolve()
    with ExitStack() as new_folders:
        _make_folder(folder, new_folders)
        place = folder.parent if os.access(folder.parent, os.W_OK | os.X_OK) else folder
        with _locked(place):
            _clean(place)
            made = _temporary(place)
            made.mkdir()
            (made / BUSY).touch()
            busy = _locked(made / BUSY)
        with busy:
            try:
                yield made
                files = [path for path in sorted(made.rglob("*")) if path.is_file() and path != made / BUSY]
                put_all({folder / path.relative_to(made): path.read_bytes() for path in files})
            finally:
                shutil.rmtree(made, ignore_errors=True)
        new_folders.pop_all()


def settle(folder: Path) -> None:
    """Finish what a killed process began to move in the folder. Raises OSError where that cannot be done."""
    if (folder / MOVES).exists():
        with _locked(folder):
            _finish(folder)


def _list_moves(fresh: Mapping[Path, Path], temporary: ExitStack) -> None:
    """From here on the result is the new one, unless a move fails; for files that share a folder."""
    folder = Path(os.path.commonpath([path.parent.absolute() for path in fresh]))
    if folder not in {path.parent.absolute() for path in fresh}:
        return
    moves = [[os.path.relpath(part, folder) for part in (source, path)] for path, source in fresh.items()]
    listed = _beside(folder / MOVES, temporary)
    listed.write_text(json.dumps(moves), encoding="utf-8")
    os.replace(listed, folder / MOVES)
    # the last callback is the first: it goes before the temporary files do
    temporary.callback((folder / MOVES).unlink, missing_ok=True)


def _finish(folder: Path) -> None:
    """Carry out the list of moves in a folder, as far as they are its own."""
    listed = folder / MOVES
    if not listed.exists():
        return
    with suppress(ValueError, TypeError):
        for source, target in json.loads(listed.read_text(encoding="utf-8")):
            old, new = Path(source), Path(target)
            inside = not new.is_absolute() and ".." not in new.parts and old.parent == new.parent
            if inside and TEMPORARY.fullmatch(old.name):
                with suppress(FileNotFoundError):  # was moved already
                    os.replace(folder / source, folder / target)
    listed.unlink(missing_ok=True)


def _clean(folder: Path) -> None:
    """The folder without what killed processes left in it."""
    _finish(folder)
    for name in os.listdir(folder):
        if TEMPORARY.fullmatch(name):
            _remove(folder / name)


def _remove(left: Path) -> None:
    """A temporary file, or a folder whose process does not live any more."""
    if not left.is_dir():
        left.unlink(missing_ok=True)
        return
    with suppress(OSError), (left / BUSY).open("w") as busy:  # in use, or a file system without locks
        fcntl.flock(busy, fcntl.LOCK_EX | fcntl.LOCK_NB)
        shutil.rmtree(left, ignore_errors=True)


def _locked(place: Path) -> ExitStack:
    """While it is open, no other process writes in the folder, or has the file."""
    held = ExitStack()
    handle = os.open(place, os.O_RDONLY)
    held.callback(os.close, handle)
    with suppress(OSError):  # a file system without locks
        fcntl.flock(handle, fcntl.LOCK_EX)
    return held


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
    name = _temporary(path.parent)
    temporary.callback(name.unlink, missing_ok=True)
    return name


def _temporary(folder: Path) -> Path:
    """A name that nothing in the folder has."""
    return folder / f".{secrets.token_hex(8)}.part"


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
