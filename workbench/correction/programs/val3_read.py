"""Stäubli VAL 3, read: the moves of an application, with points, tools and descriptors of its data."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from ...robot import rotations
from .base import Array
from .format import NUMBER
from .motions import NONE, Frame, Motions
from .posture import of_staubli
from .text import arguments, as_run, place_in_array
from .val3_data import Code, Line, Row, application, run_of

MOVE = re.compile(r"(?:\w+\s*(?:\[.*\])?\s*=\s*)?(move[jlc])\s*\(", re.I)  # it may give a number back
UNREAD = re.compile(r"\b(alterMove[jlc]\w*|move[jlc]\w*)\s*\(", re.I)
CALL = re.compile(r"call\s+([\w:]+)\s*\(", re.I)
SET = re.compile(r"(\w+)\s*(?:\[.*\])?(?:\.\w+)*\s*=(?!=)")
SETTING = {"setframe": 3, "link": 0, "insert": 0, "append": 0, "delete": 0, "resize": 0}  # which argument
SETS = re.compile(rf"\b({'|'.join(SETTING)})\s*\(", re.I)
VAL3_FREE = 99999.0  # mm/s, deg/s: does not limit
MOST_FATHERS = 20


def scan(files: Mapping[str, str]) -> Motions:
    """The motions of an application's programs in the order in which they run, those that are called in their
    place; a loop over an array runs for each of its numbers."""
    return _Reader(files).motions


class _Reader:
    """Data by name, then the moves of the programs."""

    def __init__(self, files: Mapping[str, str]) -> None:
        project = next((name for name in files if name.lower().endswith(".pjx")), next(iter(files)))
        self.motions = Motions(project)
        self.motions.name = re.sub(r"\.\w+$", "", project)
        self.data = application(project, files)
        codes = self.data.codes
        changed = {
            name: [by and key in _set(code) for key, by in code.takes.items()] for name, code in codes.items()
        }
        self.computed: set[str] = set()  # data that the programs set
        for code in codes.values():
            named = _set(code)
            for _, text in code.lines:
                if match := CALL.match(text):
                    said = [part for _, part in arguments(text[match.end() :])]
                    named |= {
                        _entry(part, {})[0]
                        for part, sets in zip(said, changed.get(match[1], []), strict=False)
                        if sets
                    }
            self.computed |= named - code.own
        lines = {name: run_of(code, self.data.sizes) for name, code in codes.items()}
        for root in as_run(lines, _called):
            self.motions.anew()
            for line in root:
                self.motions.place, self.motions.line = line.code.file, line.number
                self._line(line)
        self.motions.place, self.motions.line = project, ""

    def _line(self, line: Line) -> None:
        if match := MOVE.match(line.text):
            said = [part for _, part in arguments(line.text[match.end() :])]
            self._move(line, match[1].lower(), said)
        elif (match := UNREAD.search(line.text)) and not CALL.match(line.text):
            self.motions.fault(line.number, f"{match[1]} cannot be read", "export the path anew")
        elif match := re.match(r"delay\s*\((.+)\)", line.text, re.I):
            self.motions.wait(self._number(match[1], line) or 0.0)

    def _row(self, text: str, line: Line) -> Row | None:
        name, key = _entry(text, line.index)
        return None if name in line.code.own else self.data.rows.get(name, {}).get(key)

    def _number(self, text: str, line: Line) -> float | None:
        """A number of the data or as it stands; None where it is computed."""
        row = self._row(text, line)
        said = row.get("value", "0") if row is not None else text
        return float(said) if re.fullmatch(NUMBER, said.strip()) else None

    def _move(self, line: Line, kind: str, said: list[str]) -> None:
        """One motion: the via point of a circle, point (or joints), tool and motion descriptor."""
        points = [self._row(text, line) for text in said[:-2]]
        rows = [row for row in points if row is not None]
        if len(points) != (2 if kind == "movec" else 1) or len(rows) < len(points):
            what = f"{kind}({', '.join(said[:-2])}, ...) cannot be read"
            self.motions.fault(line.number, what, "give points as data of the application")
            return
        entries = [_entry(text, line.index) for text in said[:-2]]
        if computed := [name for name, _ in entries if name in self.computed]:
            what = f"{computed[0]} is set in a program"
            self.motions.fault(line.number, what, "give points as data alone")
            return
        pace = self._row(said[-1], line) or {}
        spots = [self.data.spots.get(entry) for entry in entries]
        share = float(pace.get("vel", 100.0)) / 100
        if any(key.startswith("j") for key in rows[-1]):
            arm = tuple(np.radians(float(rows[-1].get(f"j{i}", "0"))) for i in range(1, 7))
            self.motions.joints(arm, share=share, spot=spots[-1])
            return
        fathers = {row.get("fatherId", "world[0]") for row in rows}
        base = self._frame(fathers.pop(), "world", line)
        if base is None or fathers:
            what = f"{said[-3]} stands in {rows[-1].get('fatherId')}, which is no frame of the data alone"
            self.motions.fault(line.number, what, "give points in world or a frame of the data")
            return
        tool = said[-2].strip()
        if (found := self._frame(tool, "flange", line)) is not None:
            self.motions.tool = NONE if tool.partition("[")[0] == "flange" else Frame(found)
        elif _entry(tool, line.index)[0] in self.data.rows:
            what = f"the tool {tool} is no data alone: a program sets it, or what it stands on"
            self.motions.fault(line.number, what, "export the path anew")
            return
        else:
            self.motions.elsewhere("tool", tool)
        self.motions.base = Frame(base)
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

    def _frame(self, text: str, ground: str, line: Line) -> Array | None:
        """(4, 4) a frame or a tool of the data on `ground` (the world, or the flange), through all on which
        it stands; None where one of these is not in the data, or a program sets it."""
        X = np.eye(4)
        for _ in range(MOST_FATHERS):
            name, _ = _entry(text, line.index)
            if name == ground:
                return X
            row = self._row(text, line)
            if row is None or name in self.computed:
                return None
            X, text = _read_frame(row) @ X, row.get("fatherId", ground)
        return None


def _called(line: Line) -> str | None:
    """The program of the application that a line calls."""
    match = CALL.match(line.text)
    return match[1] if match else None


def _set(code: Code) -> set[str]:
    """Names of what a program sets."""
    names = {match[1] for _, text in code.lines if (match := SET.match(text))}
    for _, text in code.lines:
        for match in SETS.finditer(text):
            said = [part for _, part in arguments(text[match.end() :])]
            names |= {_entry(part, {})[0] for part in said[SETTING[match[1].lower()] :][:1]}
    return names


def _entry(text: str, index: Mapping[str, int]) -> tuple[str, int]:
    """Name and number of an entry of the data, as a program says it: `p`, `p[2]`, `p[i]`, `p[i+1]`; -1 where
    the number is computed."""
    match = re.fullmatch(r"\s*(\w+)\s*(?:\[(.*)\])?\s*", text)
    if match is None:
        return "", -1
    key = 0 if match[2] is None else place_in_array(match[2], index)
    return match[1], -1 if key is None else key


def _read_frame(row: Row) -> Array:
    angles = np.radians([[float(row.get(key, "0")) for key in ("rx", "ry", "rz")]])
    place = 1e-3 * np.array([[float(row.get(key, "0")) for key in "xyz"]])
    return rotations.pose(place, rotations.from_xyz(angles))[0]
