"""The files of a VAL 3 application: data with the places of their numbers, and the lines of its programs."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial

from ...files.faults import Fault, InputError
from ...files.program_text import code_of
from .loops import Index, Loop, unrolled
from .motions import Spot
from .text import place_in_array

COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
TAG = re.compile(r"""<(?:\w+:)?(Data|Value)\b(?:[^>"']|"[^"]*"|'[^']*')*>""")
ATTRIBUTE = re.compile(r"""([\w:.-]+)\s*=\s*("[^"]*"|'[^']*')""")
CODE = re.compile(r"<(?:\w+:)?code\b[^>]*>", re.I)
PLACE, JOINTS = ("x", "y", "z", "rx", "ry", "rz"), ("j1", "j2", "j3", "j4", "j5", "j6")
LOOP = re.compile(r"for\s+(\w+)\s*=\s*(.+?)\s+to\s+(.+?)(?:\s+step\s+(.+))?$", re.I)
Row = dict[str, str]


@dataclass(frozen=True)
class Code:
    """A program. takes: its parameters, whether it may change each; own: these and its local data."""

    name: str
    file: str
    takes: Mapping[str, bool]
    own: frozenset[str]
    lines: tuple[tuple[int, str], ...]


@dataclass(frozen=True)
class Line:
    """A line of a program, without comments and texts; index: loop variables there."""

    code: Code
    number: int
    text: str
    index: Index = field(default_factory=dict)


@dataclass
class Application:
    """rows: attributes of every entry of the data by name and number; sizes of arrays; spots of numbers."""

    rows: dict[str, dict[int, Row]]
    sizes: dict[str, int]
    spots: dict[tuple[str, int], Spot]
    codes: dict[str, Code]


def application(project: str, files: Mapping[str, str]) -> Application:
    """What the files hold; `InputError` where they are no XML or in inches."""
    trees = {name: _tree(name, text) for name, text in files.items()}
    inches = [item for item in trees[project].iter() if item.get("millimeterUnit", "").lower() == "false"]
    if inches:
        raise InputError(Fault(project, "is in inches (millimeterUnit)", "turn it to millimetres first"))
    found = Application(
        {}, {}, {key: spot for name, text in files.items() for key, spot in _spots(name, text)}, {}
    )
    for name, tree in trees.items():
        for item in tree.iter():
            if _tag(item) == "Data" and "name" in item.attrib:
                values = [value for value in item if _tag(value) == "Value"]
                rows = {int(key): dict(v.attrib) for v in values if (key := v.get("key", "0")).isdigit()}
                found.rows[item.get("name", "")] = rows
                size = item.get("size", "")
                found.sizes[item.get("name", "")] = int(size) if size.isdigit() else len(rows)
        if name.lower().endswith(".pgx"):
            for code in _codes(name, files[name], tree):
                known = code.name in found.codes
                found.codes[f"{name} {code.name}" if known else code.name] = code
    return found


def run_of(code: Code, sizes: Mapping[str, int]) -> list[Line]:
    """A program's lines as they run. sizes: of arrays."""
    lines = [Line(code, number, text) for number, text in code.lines]
    return list(unrolled(lines, partial(_loops, sizes)))


def _loops(sizes: Mapping[str, int], line: Line) -> Iterator[Loop | None]:
    """The loop that begins or ends in a line."""
    if line.text.lower() == "endfor":
        yield None
    elif match := LOOP.match(line.text):
        entry = re.compile(rf"\[[^]]*\b{match[1]}\b[^]]*\]")
        yield Loop(match[1], partial(_values, match, sizes), entry)


def _values(match: re.Match[str], sizes: Mapping[str, int], index: Index) -> range | None:
    """The numbers of a loop; None where a bound is computed."""
    first, last, step = (_bound(said, index, sizes) for said in (match[2], match[3], match[4] or "1"))
    if first is None or last is None or not step:
        return None
    return range(first, last + (1 if step > 0 else -1), step)


def _bound(text: str, index: Index, sizes: Mapping[str, int]) -> int | None:
    """A bound of a loop: `3`, `-1`, `size(pPath)-1`."""
    if match := re.fullmatch(r"size\(\s*(\w+)\s*\)\s*(?:([-+])\s*(\d+))?", text):
        size = sizes.get(match[1])
        return None if size is None else size + int(f"{match[2] or '+'}{match[3] or 0}")
    return int(text) if re.fullmatch(r"-?\d+", text) else place_in_array(text, index)


def _codes(file: str, text: str, tree: ET.Element) -> Iterator[Code]:
    """The programs of a file; the lines are numbered as in the file."""
    blank = COMMENT.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
    begins = [blank.count("\n", 0, match.end()) + 1 for match in CODE.finditer(blank)]
    programs = [item for item in tree.iter() if _tag(item).lower() == "program"]
    found = [(item, code) for item in programs for code in item.iter() if _tag(code).lower() == "code"]
    for (item, code), begin in zip(found, begins, strict=False):
        said = code_of(code.text or "", "//").splitlines()
        lines = tuple((begin + i, line.strip()) for i, line in enumerate(said))
        takes = {
            one.get("name", ""): one.get("use", "reference") != "value"
            for one in item.iter()
            if _tag(one).lower() == "parameter"
        }
        own = {one.get("name", "") for one in item.iter() if _tag(one).lower() == "local"}
        yield Code(item.get("name", file), file, takes, frozenset({*own, *takes}), lines)


def _spots(file: str, text: str) -> Iterator[tuple[tuple[str, int], Spot]]:
    """Where the numbers of every point and of all joints stand in a file of data."""
    name = ""
    for tag in TAG.finditer(COMMENT.sub(lambda found: " " * len(found[0]), text)):
        where = {one[1]: one.span(2) for one in ATTRIBUTE.finditer(text, tag.end(1), tag.end())}
        said = {key: text[start + 1 : end - 1] for key, (start, end) in where.items()}
        if tag[1] == "Data":
            name = said.get("name", "")
            continue
        keys = JOINTS if any(key in where for key in JOINTS) else PLACE
        spans, absent = [], []
        for key in keys:
            start, end = where.get(key, (tag.end(1) - 1, tag.end(1) + 1))
            spans.append((start + 1, end - 1))
            absent.append("" if key in where else f' {key}="{{}}"')
        if said.get("key", "0").isdigit():
            yield (name, int(said.get("key", "0"))), Spot(file, tuple(spans), tuple(absent))


def _tree(name: str, text: str) -> ET.Element:
    try:
        return ET.fromstring(text.lstrip("\ufeff").encode())
    except ET.ParseError as error:
        raise InputError(Fault(name, f"is not XML: {error}")) from None


def _tag(item: ET.Element) -> str:
    return item.tag.rsplit("}", 1)[-1]
