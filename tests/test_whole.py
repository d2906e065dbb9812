"""Files of one result: all in place, or everything as it was."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from workbench.files.whole import put, put_all


def content(folder: Path) -> dict[str, str]:
    """Everything under a folder, hidden files too."""
    return {
        str(file.relative_to(folder)): file.read_text(encoding="utf-8") if file.is_file() else "folder"
        for file in sorted(folder.rglob("*"))
    }


def fail_at(monkeypatch: pytest.MonkeyPatch, count: int, error: BaseException) -> None:
    """The move number `count` fails; those after it (back to where things were) work again."""
    real, calls = os.replace, []

    def failing(source: Path, target: Path) -> None:
        calls.append(target)
        if len(calls) == count:
            raise error
        real(source, target)

    monkeypatch.setattr(os, "replace", failing)


def test_one_file_with_its_folders(tmp_path: Path) -> None:
    put(tmp_path / "new" / "deep" / "file.txt", "ä\r\nö\n")
    assert (tmp_path / "new" / "deep" / "file.txt").read_bytes() == "ä\r\nö\n".encode()
    put(tmp_path / "new" / "deep" / "file.txt", b"\x00")
    assert content(tmp_path) == {"new": "folder", "new/deep": "folder", "new/deep/file.txt": "\x00"}


def test_names_may_be_as_long_as_the_disk_takes(tmp_path: Path) -> None:
    put(tmp_path / ("x" * 255), "long")
    assert content(tmp_path) == {"x" * 255: "long"}


def test_rights_are_those_of_any_new_file(tmp_path: Path) -> None:
    (tmp_path / "usual").write_text("")
    put(tmp_path / "ours", "")
    usual, ours = (stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("usual", "ours"))
    assert usual == ours


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("failing", [1, 2, 3])
def test_a_file_that_fails_takes_the_others_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, failing: int
) -> None:
    (tmp_path / "first").write_text("old")
    (tmp_path / "third").write_text("older")
    before = content(tmp_path)
    fail_at(monkeypatch, failing, error)
    with pytest.raises(type(error)):
        put_all({tmp_path / "first": "1", tmp_path / "new" / "second": "2", tmp_path / "third": "3"})
    assert content(tmp_path) == before


def test_what_cannot_be_written_moves_nothing(tmp_path: Path) -> None:
    (tmp_path / "first").write_text("old")
    (tmp_path / "second").mkdir()
    before = content(tmp_path)
    with pytest.raises(OSError):  # noqa: PT011  # a folder is in the way: each system has its own words
        put_all({tmp_path / "first": "1", tmp_path / "second": "2"})
    with pytest.raises(UnicodeEncodeError):
        put_all({tmp_path / "first": "1", tmp_path / "deep" / "third": "\ud800"})
    assert content(tmp_path) == before


def test_what_stood_there_comes_back_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "script").write_text("old")
    (tmp_path / "script").chmod(0o754)
    (tmp_path / "link").symlink_to("script")
    fail_at(monkeypatch, 3, OSError("full"))
    with pytest.raises(OSError, match="full"):
        put_all({tmp_path / "script": "1", tmp_path / "link": "2", tmp_path / "third": "3"})
    assert stat.S_IMODE((tmp_path / "script").stat().st_mode) == 0o754
    assert (tmp_path / "link").is_symlink()
    assert sorted(os.listdir(tmp_path)) == ["link", "script"]
