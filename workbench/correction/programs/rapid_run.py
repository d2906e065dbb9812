"""The statements of a RAPID module in the order in which they run."""

from __future__ import annotations

import re
from bisect import bisect
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

from .loops import Index, Loop, unrolled
from .rapid_data import calls
from .text import as_run

# between these, in turn: the module's data, and a routine's own
ROUTINE = re.compile(r"\b(?:PROC|FUNC|TRAP|ENDPROC|ENDFUNC|ENDTRAP)\b", re.I)
NAME = re.compile(r"(?:PROC|FUNC\s+\w+|TRAP)\s+(\w+)", re.I)
LOOP = re.compile(
    r"\bENDFOR\b|\bFOR\s+(\w+)\s+FROM\s+(.*?)\s+TO\s+(.*?)(?:\s+STEP\s+(.*?))?\s+DO\b", re.I | re.S
)


@dataclass(frozen=True)
class Statement:
    """Up to a semicolon: where it begins, the number of its routine, and the loop variables there."""

    start: int
    text: str
    routine: int
    index: Index = field(default_factory=dict)


def routines(code: str) -> list[int]:
    """Where routines begin and end, in turn."""
    return [match.start() for match in ROUTINE.finditer(code)]


def in_order(
    code: str, statements: Sequence[tuple[int, str]], bounds: Sequence[int]
) -> Iterator[Iterator[Statement]]:
    """The statements of each routine that no other of the module calls, with those of the called ones in
    their place. A loop over an array runs for each of its numbers; others run once."""
    programs: dict[str, list[Statement]] = {"": []}
    names, procedures = {0: ""}, set[str]()
    for i, at in enumerate(bounds, 1):
        match = NAME.match(code, at)
        names[i] = "" if match is None else match[1].upper()
        if match and names[i] in programs:
            names[i] += f" {i}"  # of another module in the file
        programs.setdefault(names[i], [])
        if match and match[0][:4].upper() == "PROC":
            procedures.add(match[1].upper())
    for start, text in statements:
        routine = bisect(bounds, start + len(text) - 1)
        programs[names[routine]].append(Statement(start, text, routine))
    known = calls(procedures)  # of a trap or a function a name alone is no call

    def called(statement: Statement) -> str | None:
        match = known.search(statement.text) if known else None
        return match[1].upper() if match else None

    return as_run({name: list(unrolled(lines, _loops)) for name, lines in programs.items()}, called)


def _loops(statement: Statement) -> Iterator[Loop | None]:
    """The loops that begin and end in a statement."""
    for match in LOOP.finditer(statement.text):
        if match[1] is None:
            yield None
            continue
        entry = re.compile(rf"\{{[^}}]*\b{match[1]}\b[^}}]*\}}", re.I)
        yield Loop(match[1].lower(), partial(_values, match), entry)


def _values(match: re.Match[str], _: Index) -> range | None:
    """The numbers of a loop; None where a bound is computed."""
    bounds = [text.strip() for text in (match[2], match[3], match[4] or "1")]
    if not all(re.fullmatch(r"-?\d+", text) for text in bounds):
        return None
    first, last, step = (int(text) for text in bounds)
    step = step if match[4] or first <= last else -1
    return (range(first, last + (1 if step > 0 else -1), step) or None) if step else None
