"""Where in a TOML file a fault of its schema is, and the keys that stand there."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel

Place = tuple[str | int, ...]  # keys, and numbers of tables in an array of them, as pydantic says them

HEAD = re.compile(r"""(\[\[?)([^\[\],]+)\]\]?\s*(?:#.*)?$""")
PART = re.compile(r""""([^"]*)"|'([^']*)'|([\w-]+)""")


def places(text: str) -> dict[Place, int]:
    """Line, from 1, of every table and key that has one of its own."""
    found: dict[Place, int] = {}
    for number, place in _lines(text):
        found.setdefault(place, number)
    return found


def line_of(place: Place, lines: Mapping[Place, int]) -> int | None:
    """The line of a place among `places`, or of the nearest table around it; None: none says it."""
    around = (place[:depth] for depth in range(len(place), 0, -1))
    return next((lines[one] for one in around if one in lines), None)


def _lines(text: str) -> Iterator[tuple[int, Place]]:
    """Number and place of every line that opens a table or sets a key."""
    table: Place = ()
    count: dict[Place, int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        if head := HEAD.match(line.strip()):
            table = ()
            *above, last = _parts(head[2]) or [""]
            for key in above:
                table = (*table, key)
                if table in count:
                    table = (*table, count[table])
            table = (*table, last)
            if head[1] == "[[":
                count[table] = count.get(table, -1) + 1
                table = (*table, count[table])
            yield number, table
        elif "=" in line and (keys := _parts(line.partition("=")[0])):
            yield number, (*table, *keys)


def _parts(dotted: str) -> list[str]:
    """The keys of a dotted key; none where it is none."""
    if PART.sub("", dotted).strip(" \t."):
        return []
    return ["".join(part) for part in PART.findall(dotted)]


def keys_at(model: type[BaseModel], place: Place) -> list[str]:
    """The keys that the table at a place may have; none where the schema does not say."""
    kind: Any = model
    for part in place:
        if fields := _fields(kind):
            kind = fields.get(str(part))
        else:  # a table of any names, or an array
            inside = [get_args(one) for one in _kinds(kind) if len(get_args(one)) > 1]
            kind = inside[0][isinstance(part, str)] if inside else None
    return sorted(_fields(kind))


def _kinds(kind: Any) -> Sequence[Any]:
    """What an annotation allows, each by itself."""
    if get_origin(kind) is Annotated:
        return _kinds(get_args(kind)[0])
    if get_origin(kind) in (None, dict, tuple, list):
        return [kind]
    return [one for part in get_args(kind) for one in _kinds(part)]


def _fields(kind: Any) -> dict[str, Any]:
    """Key → annotation, of the tables among what an annotation allows."""
    tables = [one for one in _kinds(kind) if isinstance(one, type) and issubclass(one, BaseModel)]
    return {
        field.alias or name: field.annotation for one in tables for name, field in one.model_fields.items()
    }
