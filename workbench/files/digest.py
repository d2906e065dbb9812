"""What says which files a result was made from."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path


def digests(files: Iterable[Path]) -> dict[str, str]:
    """ "<folder>/<file>" → SHA-256, of those that are there."""
    return {
        f"{file.resolve().parent.name}/{file.name}": hashlib.sha256(file.read_bytes()).hexdigest()
        for file in files
        if file.is_file()
    }
