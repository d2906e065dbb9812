"""Loops of a program over the entries of an array: run for each of their numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import Field, dataclass, field, replace
from typing import Any, ClassVar, Generic, Protocol, TypeVar

Index = Mapping[str, int]  # loop variables


class Looped(Protocol):
    """A dataclass: a line or a statement of a program, with the loop variables there."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def text(self) -> str: ...

    @property
    def index(self) -> Index: ...


Line = TypeVar("Line", bound=Looped)


@dataclass(frozen=True)
class Loop:
    """A loop that begins. values: of its variable, by those of the loops around it; None where they are
    computed. entry: finds an entry of an array that its variable names."""

    name: str
    values: Callable[[Index], range | None]
    entry: re.Pattern[str]


def unrolled(lines: Sequence[Line], loops: Callable[[Line], Iterable[Loop | None]]) -> Iterator[Line]:
    """A program's lines, those of loops over arrays again for each number that the loop has; others run once.
    loops: those that begin in a line, and None for one that ends; what begins one is in it."""
    blocks = [_Block[Line](None)]
    for line in lines:
        for loop in loops(line):
            if loop is None:
                blocks = blocks[:-1] if len(blocks) > 1 else blocks
                continue
            block = _Block[Line](loop)
            blocks[-1].inner.append(block)
            blocks.append(block)
        blocks[-1].inner.append(line)
    return blocks[0].run({})


@dataclass
class _Block(Generic[Line]):
    """Lines and loops within a loop, or within the program."""

    loop: Loop | None
    inner: list[Line | _Block[Line]] = field(default_factory=list)

    def run(self, index: Index) -> Iterator[Line]:
        for now in self._each(index):
            for one in self.inner:
                if isinstance(one, _Block):
                    yield from one.run(now)
                else:
                    yield replace(one, index=now)

    def _each(self, index: Index) -> Iterator[Index]:
        """The loop variables in each round."""
        if self.loop is None:
            yield index
            return
        values = self.loop.values(index) if self._has(self.loop.entry) else None
        outer = {name: value for name, value in index.items() if name != self.loop.name}
        if values is None:
            yield outer
            return
        for value in values:
            yield {**outer, self.loop.name: value}

    def _has(self, entry: re.Pattern[str]) -> bool:
        return any(
            one._has(entry) if isinstance(one, _Block) else bool(entry.search(one.text)) for one in self.inner
        )
