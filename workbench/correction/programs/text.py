"""What the readers of several formats share."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TypeVar

Line = TypeVar("Line")
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


def place_in_array(text: str, index: Mapping[str, int]) -> int | None:
    """The number of an array's entry, `2`, `i` or `i+1`, with loop variables by their names; None where it is
    computed."""
    match = re.fullmatch(r"\s*(\w+)\s*(?:([-+])\s*(\d+))?\s*", text)
    if match is None:
        return None
    first = int(match[1]) if match[1].isdigit() else index.get(match[1])
    return None if first is None else first + int(f"{match[2] or '+'}{match[3] or 0}")


def as_run(
    programs: Mapping[str, Sequence[Line]], called: Callable[[Line], str | None]
) -> Iterator[Iterator[Line]]:
    """The lines of programs in the order in which they run, those that a line calls (`called`: its name) in
    its place: of each program that no other calls, and of the first of those that only call each other."""
    calls = {
        name: [other for line in lines if (other := called(line)) in programs and other != name]
        for name, lines in programs.items()
    }

    def lines_of(name: str, within: tuple[str, ...]) -> Iterator[Line]:
        for line in programs[name]:
            other = called(line)
            if other in programs and other not in within and other is not None:
                yield from lines_of(other, (*within, other))
            else:
                yield line

    inner = {other for others in calls.values() for other in others}
    roots, reached = list[str](), set[str | None]()
    for name in (*(name for name in programs if name not in inner), *programs):
        if name in reached:
            continue
        roots.append(name)
        new: list[str | None] = [name]
        while new:
            one = new.pop()
            if one is not None and one not in reached:
                reached.add(one)
                new += calls[one]
    return (lines_of(name, (name,)) for name in roots)
