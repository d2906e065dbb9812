"""What robot programs have in common as text."""

from __future__ import annotations

import re

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"  # as most programs write one
NO_AXIS = 8e9  # from here on RAPID has no external axis


def code_of(text: str, comment: str) -> str:
    """The text with blanks in the place of strings and comments, so that every place stays where it is.
    comment: the sign that one begins with."""
    words = rf'"[^"\n]*"|{re.escape(comment)}[^\n]*'
    return re.sub(words, lambda match: " " * len(match[0]), text)
