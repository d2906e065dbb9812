"""One way to say that the input is wrong: every fault at once, where it is, and how to mend it."""

from __future__ import annotations

import re
import stat
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from .whole import settle

BYTE_ORDER_MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
LARGEST = 1 << 29  # bytes of a file that is read
CONTROL = re.compile("[\x00-\x08\x0b\x0e-\x1f\x7f-\x84\x86-\x9f]")  # act in a terminal, are no text
BUILD = re.compile(r"Failure at \S+ in ")  # before what Drake says
FAULTS_SHOWN = 10  # faults of one kind that are listed one by one; the rest is counted


@dataclass(frozen=True)
class Fault:
    """One thing wrong with the user's input.

    `place` names the file, line and column as far as they are known; `what` says what is
    wrong; `mend` says what to do about it.
    """

    place: str
    what: str
    mend: str = ""

    def __str__(self) -> str:
        return f"{self.place}: {self.what}" + (f"; {self.mend}" if self.mend else "")


class InputError(ValueError):
    """The input or the call is wrong (exit status 2). Carries all faults, one line each."""

    def __init__(self, faults: Sequence[Fault] | Fault) -> None:
        self.faults: tuple[Fault, ...] = (faults,) if isinstance(faults, Fault) else tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[Fault, ...]]]:
        """From another process it comes with its faults."""
        return type(self), (self.faults,)


def plain(text: str) -> str:
    """The text with what acts in a terminal made visible, and without places in Drake's own source."""
    return CONTROL.sub(lambda found: repr(found[0])[1:-1], BUILD.sub("", text))


def counted(faults: Sequence[Fault]) -> list[Fault]:
    """Many faults of one kind: the first ones in full, the rest counted at the place of the last."""
    rest = len(faults) - FAULTS_SHOWN
    if rest <= 1:
        return list(faults)
    return [*faults[:FAULTS_SHOWN], Fault(faults[-1].place, f"and {rest} more like this up to here")]


def line_faults(path: Path, told: Iterable[tuple[int, str, str]]) -> list[Fault]:
    """One fault per line (its number, what, how to mend it): the first ones in full, the rest counted."""
    return counted([Fault(f"{path} line {line}", what, mend) for line, what, mend in told])


def read_text(path: Path, encoding: str = "utf-8") -> str:
    """The file's text; `InputError` when it is missing, a folder, endless, not in that encoding, or holds
    characters that act in a terminal. A byte order mark says the encoding itself: UTF-8 or UTF-16.
    """
    return text_of(read_bytes(path), path, encoding)


def read_bytes(path: Path) -> bytes:
    """What is in the file; `InputError` when it is missing, a folder, or endless."""
    try:
        if stat.S_ISCHR(path.stat().st_mode):
            raise InputError(Fault(str(path), "is a device, not a file", "name a file"))
        settle(path.parent)
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except FileNotFoundError:
        raise InputError(Fault(str(path), "no such file", "check the path")) from None
    except IsADirectoryError:
        raise InputError(Fault(str(path), "is a folder, not a file", "name the file in it")) from None
    except OSError as error:
        raise InputError(Fault(str(path), error.strerror or "cannot be read")) from None
    except InputError:
        raise
    except ValueError as error:  # a null byte in the path
        raise InputError(Fault(repr(str(path)), f"is no path ({error})")) from None
    if len(content) > LARGEST:
        raise InputError(Fault(str(path), f"is larger than {LARGEST >> 20} MB", "split it"))
    return content


def text_of(content: bytes, path: Path, encoding: str) -> str:
    """The text of a file's content. See `read_text`."""
    text = _decoded(path, content, encoding).replace("\r\n", "\n").replace("\r", "\n")
    if (found := CONTROL.search(text)) is not None:
        line = text.count("\n", 0, found.start()) + 1
        what, mend = f"has the control character {found.group()!r}", "is it text? take the character out"
        if found.group() == "\x00":
            mend = (
                'is it UTF-16 without a mark? save it as UTF-8; of a table, encoding = "utf-16-le" may say it'
            )
        raise InputError(Fault(f"{path} line {line}", what, mend))
    return text


def _decoded(path: Path, content: bytes, encoding: str) -> str:
    marked = next((name for mark, name in BYTE_ORDER_MARKS.items() if content.startswith(mark)), encoding)
    try:
        return content.decode(marked)
    except UnicodeDecodeError as error:
        said = "UTF-8" if marked.startswith("utf-8") else marked
        mend = 'save it as UTF-8; of a table, encoding = "latin-1" may say it'
        raise InputError(Fault(str(path), f"is not {said} text (byte {error.start})", mend)) from None
