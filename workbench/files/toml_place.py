"""Where in a TOML file a fault of its schema is, and the keys that stand there."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel

from .faults import Fault, InputError, read_text

Place = tuple[str | int, ...]  # keys, and numbers of tables in an array of them, as pydantic says them

HEAD = re.compile(r"""(\[\[?)([^\[\],]+)\]\]?\s*(?:#.*)?$""")
DOTTED = re.compile(r"""(?:"[^"]*"|'[^']*'|[\w-]+)(?:\.(?:"[^"]*"|'[^']*'|[\w-]+))*""")
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


def with_lines(faults: Sequence[Fault], path: Path) -> list[Fault]:
    """Faults `PATH: KEY ...` of a TOML that were found behind its schema, with the line of the key, or of the
    nearest table around it. A table in an array goes by its `name`."""
    begin, out = f"{path}: ", list[Fault]()
    try:
        lines, content = places(text := read_text(path)), tomllib.loads(text)
    except (InputError, tomllib.TOMLDecodeError):
        return list(faults)
    for fault in faults:
        key = fault.place.removeprefix(begin)
        said = DOTTED.match(key) if key != fault.place else None
        line = line_of(_place_of(_parts(said[0]), content), lines) if said else None
        out.append(replace(fault, place=f"{path} line {line}: {key}") if line else fault)
    return out


def _place_of(keys: Sequence[str], content: Any) -> Place:
    """Keys as a place: of an array the number of the table that has the next key for a name."""
    place: Place = ()
    for key in keys:
        if isinstance(content, list):
            names = [one.get("name") if isinstance(one, dict) else None for one in content]
            if key not in names:
                break
            place, content = (*place, names.index(key)), content[names.index(key)]
        else:
            place, content = (*place, key), content.get(key) if isinstance(content, dict) else None
    return place


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
            inside = [get_args(one) for one in kinds(kind) if len(get_args(one)) > 1]
            kind = inside[0][isinstance(part, str)] if inside else None
    return sorted(_fields(kind))


def kinds(kind: Any) -> Sequence[Any]:
    """What an annotation allows, each by itself."""
    if get_origin(kind) is Annotated:
        return kinds(get_args(kind)[0])
    if get_origin(kind) in (None, dict, tuple, list):
        return [kind]
    return [one for part in get_args(kind) for one in kinds(part)]


def _fields(kind: Any) -> dict[str, Any]:
    """Key → annotation, of the tables among what an annotation allows."""
    tables = [one for one in kinds(kind) if isinstance(one, type) and issubclass(one, BaseModel)]
    return {
        field.alias or name: field.annotation for one in tables for name, field in one.model_fields.items()
    }
