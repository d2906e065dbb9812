"""What the readers of several formats share."""

from __future__ import annotations

OPEN, CLOSED = "[({", "])}"


def arguments(text: str) -> list[tuple[int, str]]:
    """The parts between the commas outside of brackets up to a bracket that closes them all, with the place
    in the text where each begins."""
    parts, depth, start = [], 0, 0
    for place, letter in enumerate([*text, ","]):
        depth += (letter in OPEN) - (letter in CLOSED)
        if depth < 0 or (letter == "," and depth == 0):
            part = text[start:place]
            parts.append((start + len(part) - len(part.lstrip()), part.strip()))
            start = place + 1
        if depth < 0:
            break
    return parts
