"""Texts from files as they can stand on a page, in a figure and in a PDF."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

# What has no shape and does something (control characters, changes of writing direction), or what no XML may
# hold (halves of a surrogate pair, noncharacters). Tab and newline stay.
SHAPELESS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")


def legible(value: Any) -> Any:
    """A text with � for each character that has no shape; likewise all texts in tables, lists and frozen
    dataclasses. Anything else comes back as it is."""
    if isinstance(value, str):
        return SHAPELESS.sub("\ufffd", value)
    if isinstance(value, Mapping):
        return {legible(key): legible(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(legible(item) for item in value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{field.name: legible(getattr(value, field.name)) for field in fields(value)})
    return value
