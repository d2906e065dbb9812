"""The statements of a RAPID module in the order in which they run."""

from __future__ import annotations

import re
from bisect import bisect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

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
    index: Mapping[str, int] = field(default_factory=dict)


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

    return as_run({name: list(_unrolled(lines)) for name, lines in programs.items()}, called)


@dataclass
class _Loop:
    """Statements and loops within a loop. values: of its variable; None where it runs once."""

    name: str = ""
    values: range | None = None
    inner: list[Statement | _Loop] = field(default_factory=list)

    def run(self, index: Mapping[str, int]) -> Iterator[Statement]:
        for value in self.values or (None,):
            now = index if value is None else {**index, self.name: value}
            for one in self.inner:
                if isinstance(one, _Loop):
                    yield from one.run(now)
                else:
                    yield Statement(one.start, one.text, one.routine, now)

    def over(self, entry: re.Pattern[str]) -> bool:
        """Whether an entry of an array is named so in it."""
        return any(
            one.over(entry) if isinstance(one, _Loop) else bool(entry.search(one.text)) for one in self.inner
        )


def _unrolled(statements: Sequence[Statement]) -> Iterator[Statement]:
    """A routine's statements, those of loops over arrays again for each number that the loop has."""
    loops = [_Loop()]
    for statement in statements:
        for match in LOOP.finditer(statement.text):
            if match[1] is None:
                loops = loops[:-1] if len(loops) > 1 else loops
                continue
            bounds = [text.strip() for text in (match[2], match[3], match[4] or "1")]
            whole = all(re.fullmatch(r"-?\d+", text) for text in bounds)
            first, last, step = (int(text) for text in bounds) if whole else (0, 0, 1)
            step = step if match[4] or first <= last else -1
            values = range(first, last + (1 if step > 0 else -1), step) if whole and step else None
            loop = _Loop(match[1].lower(), values)
            loops[-1].inner.append(loop)
            loops.append(loop)
        loops[-1].inner.append(statement)
    for loop in _all(loops[0]):
        if not loop.over(re.compile(rf"\{{[^}}]*\b{loop.name}\b[^}}]*\}}", re.I)):
            loop.values = None
    return loops[0].run({})


def _all(loop: _Loop) -> Iterator[_Loop]:
    for one in loop.inner:
        if isinstance(one, _Loop):
            yield one
            yield from _all(one)
