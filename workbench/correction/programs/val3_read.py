"""Stäubli VAL 3, read: the moves of an application, with points, tools and descriptors of its data."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping

import numpy as np

from ...files.faults import Fault, InputError
from ...robot import rotations
from .base import Array
from .format import NUMBER
from .motions import NONE, Frame, Motions, Spot
from .posture import of_staubli
from .text import arguments

COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
TAG = re.compile(r"""<(?:\w+:)?(Data|Value)\b(?:[^>"']|"[^"]*"|'[^']*')*>""")
ATTRIBUTE = re.compile(r"""([\w:.-]+)\s*=\s*("[^"]*"|'[^']*')""")
PLACE, JOINTS = ("x", "y", "z", "rx", "ry", "rz"), ("j1", "j2", "j3", "j4", "j5", "j6")
SET = re.compile(r"(\w+)\s*(?:\[[^\]]*\])?(?:\.\w+)*\s*=(?!=)")
VAL3_FREE = 99999.0  # mm/s, deg/s: does not limit
Row = dict[str, str]


def scan(files: Mapping[str, str]) -> Motions:
    """The motions of an application's programs in their order; a loop stands for its whole array."""
    return _Reader(files).motions


class _Reader:
    """Data by name, then the moves of the programs."""

    def __init__(self, files: Mapping[str, str]) -> None:
        project = next((name for name in files if name.lower().endswith(".pjx")), next(iter(files)))
        self.motions = Motions(project)
        self.motions.name = re.sub(r"\.\w+$", "", project)
        trees = {name: _tree(name, text) for name, text in files.items()}
        self.rows: dict[str, dict[int, Row]] = {}
        self.computed: set[str] = set()  # data that the programs set
        self.spots = {key: spot for name, text in files.items() for key, spot in _spots(name, text)}
        for tree in trees.values():
            for item in tree.iter():
                if _tag(item) == "Data" and "name" in item.attrib:
                    values = [value for value in item if _tag(value) == "Value"]
                    self.rows[item.get("name", "")] = {
                        int(key): dict(v.attrib) for v in values if (key := v.get("key", "0")).isdigit()
                    }
        programs: list[tuple[str, list[str]]] = []
        for name, tree in trees.items():
            for item in tree.iter():
                if name.lower().endswith(".pgx") and _tag(item).lower() == "code":
                    lines = [re.sub(r"//.*", "", line).strip() for line in (item.text or "").splitlines()]
                    self.computed |= {match[1] for line in lines if (match := SET.match(line))}
                    programs.append((name, lines))
        for name, lines in programs:
            self._block(lines, name, {})

    def _block(self, lines: list[str], place: str, index: Mapping[str, int]) -> None:
        """Goes through lines; `index` holds the loop variables."""
        i = 0
        while i < len(lines):
            line = lines[i]
            loop = re.match(r"for\s+(\w+)\s*=\s*(\d+)\s+to\s+(\d+)", line, re.I)
            if loop:
                end = next((k for k in range(i, len(lines)) if lines[k].lower() == "endfor"), len(lines))
                for value in range(int(loop[2]), int(loop[3]) + 1):
                    self._block(lines[i + 1 : end], place, {**index, loop[1]: value})
                i = end
            elif match := re.match(r"(move[jlc])\s*\(", line, re.I):
                said = [part for _, part in arguments(line[match.end() :])]
                self._move(place, match[1].lower(), said, index)
            elif match := re.match(r"delay\s*\((.+)\)", line, re.I):
                self.motions.wait(self._number(match[1], index) or 0.0)
            i += 1

    def _row(self, text: str, index: Mapping[str, int]) -> Row | None:
        name, key = _entry(text, index)
        return self.rows.get(name, {}).get(key)

    def _number(self, text: str, index: Mapping[str, int]) -> float | None:
        """A number of the data or as it stands; None where it is computed."""
        row = self._row(text, index)
        said = row.get("value", "0") if row is not None else text
        return float(said) if re.fullmatch(NUMBER, said.strip()) else None

    def _move(self, place: str, kind: str, said: list[str], index: Mapping[str, int]) -> None:
        """One motion: the via point of a circle, point (or joints), tool and motion descriptor."""
        points = [self._row(text, index) for text in said[:-2]]
        if len(points) != (2 if kind == "movec" else 1) or any(row is None for row in points):
            what = f"{kind}({', '.join(said[:-2])}, ...) cannot be read"
            self.motions.fault(place, what, "give points as data of the application")
            return
        if computed := [text for text in said[:-2] if _entry(text, index)[0] in self.computed]:
            self.motions.fault(place, f"{computed[0]} is set in a program", "give points as data alone")
            return
        tool, pace = self._row(said[-2], index), self._row(said[-1], index) or {}
        rows = [row for row in points if row is not None]
        spots = [self.spots.get(_entry(text, index)) for text in said[:-2]]
        share = float(pace.get("vel", 100.0)) / 100
        if any(key.startswith("j") for key in rows[-1]):
            arm = tuple(np.radians(float(rows[-1].get(f"j{i}", "0"))) for i in range(1, 7))
            self.motions.joints(arm, share=share, spot=spots[-1])
            return
        father = rows[-1].get("fatherId", "world[0]")
        base = np.eye(4) if father in ("world[0]", "world") else self._base(father, index)
        if base is None:
            self.motions.fault(
                place, f"{said[-3]} stands in {father}", "give points in world or a frame of the data"
            )
            return
        self.motions.base = Frame(base)
        if tool is not None:
            self.motions.tool = Frame(_read_frame(tool))
        elif said[-2].strip().lower() not in ("flange", "flange[0]"):
            self.motions.elsewhere("tool", said[-2].strip())
        else:
            self.motions.tool = NONE
        limits = [float(pace.get(key, VAL3_FREE)) for key in ("tmax", "rmax")]
        free = kind == "movej"
        speed, turn = (np.nan if free or limit >= VAL3_FREE else limit for limit in limits)
        blend = float(pace.get("leave", 0.0)) if pace.get("blend", "off").lower() != "off" else 0.0
        self.motions.pose(
            _read_frame(rows[-1]),
            speed=1e-3 * speed,
            turn=np.radians(turn),
            blend=1e-3 * blend,
            share=share if free else np.nan,
            via=_read_frame(rows[0]) if kind == "movec" else None,
            spot=spots[-1],
            via_spot=spots[0] if kind == "movec" else None,
            free=free,
            posture=of_staubli([rows[-1].get(key, "").lower() for key in ("shoulder", "elbow", "wrist")]),
        )

    def _base(self, father: str, index: Mapping[str, int]) -> Array | None:
        """A frame of the data that stands in the world."""
        row = self._row(father, index)
        return (
            _read_frame(row)
            if row is not None and row.get("fatherId", "world[0]").startswith("world")
            else None
        )


def _entry(text: str, index: Mapping[str, int]) -> tuple[str, int]:
    """Name and number of an entry of the data, as a program says it: `p`, `p[2]`, `p[i]`."""
    match = re.fullmatch(r"\s*(\w+)\s*(?:\[\s*(\w+)\s*\])?\s*", text)
    if match is None:
        return "", -1
    key = match[2] or "0"
    return match[1], index.get(key, int(key) if key.isdigit() else -1)


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


def _read_frame(row: Row) -> Array:
    angles = np.radians([[float(row.get(key, "0")) for key in ("rx", "ry", "rz")]])
    place = 1e-3 * np.array([[float(row.get(key, "0")) for key in "xyz"]])
    return rotations.pose(place, rotations.from_xyz(angles))[0]
