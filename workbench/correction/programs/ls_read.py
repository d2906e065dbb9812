"""Fanuc LS, read: instructions of /MN with the positions of /POS."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...robot import rotations
from .base import Array
from .motions import NONE, Frame, Motions, Spot
from .posture import Posture, of_fanuc

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
FIELD = re.compile(rf"\b(X|Y|Z|W|P|R|J\d|E\d)\s*=\s*({NUMBER})")
TARGET = r"(PR?)\[(\d+)[^\]]*\]"
MOVE = re.compile(
    rf"^([JLCA])\s+{TARGET}(?:[\s:]*{TARGET})?\s*(?:({NUMBER})\s*(%|[a-z/]+))?\s*(FINE|CNT\s*\d+)?", re.I
)
POSITION = re.compile(r"P\[(\d+)[^\]]*\]\s*\{(.*?)\}\s*;", re.S)
METRES = {"mm/sec": 1e-3, "cm/min": 1e-2 / 60, "inch/min": 0.0254 / 60}
SECONDS = {"sec": 1.0, "msec": 1e-3}
POSE, JOINTS = "XYZWPR", tuple(f"J{i}" for i in range(1, 7))


UNREAD = re.compile(r"[JLCAS]\s+PR?\s*\[", re.I)  # PR[R[1]]
SHIFTED = re.compile(r"OFFSET|\bINC\b", re.I)
NUMBERED = re.compile(r"(UFRAME|UTOOL|BENUTZER|WKZ)_NUM\s*=\s*(\d+)?", re.I)
KINDS = {"BENUTZER": "UFRAME", "WKZ": "UTOOL"}  # of controllers in German


@dataclass(frozen=True)
class _Position:
    """frame, tool: their numbers; None: those in force."""

    fields: dict[str, float]
    spot: Spot | None
    frame: int | None
    tool: int | None
    posture: Posture | None


def scan(files: Mapping[str, str]) -> Motions:
    """The motions of a .ls, with the places of their numbers."""
    file, text = next(iter(files.items()))
    reader = _Reader(file)
    if match := re.search(r"^/PROG\s+(\w+)", text, re.M):
        reader.motions.name = match[1]
    begin = text.find("/POS")
    begin = len(text) if begin < 0 else begin
    for match in POSITION.finditer(text, begin):
        reader.positions[match[1]] = reader.position(match.start(2), match[2].split("GP2")[0])
    reader.computed = set(re.findall(r"^[ \t]*\d*[ \t]*:[ \t]*P\[(\d+)[^\]]*\]\s*=", text[:begin], re.M))
    for match in re.finditer(r"^[ \t]*\d*[ \t]*:[ \t]*(.*?)(?:;|$(?!\s*:))", text[:begin], re.M | re.S):
        reader.motions.line = text.count("\n", 0, match.start(1)) + 1
        reader.read(" ".join(match[1].split()))
    return reader.motions


class _Reader:
    """Goes through the instructions, with frames and position registers as far as the program sets them."""

    def __init__(self, file: str) -> None:
        self.file, self.motions = file, Motions(file)
        self.positions: dict[str, _Position] = {}
        self.registers: dict[str, dict[int, float]] = {}
        self.frames = {("UFRAME", 0): NONE}
        self.computed: set[str] = set()  # positions that the program sets
        self.in_force: dict[str, int | None] = {}

    def position(self, start: int, block: str) -> _Position:
        fields, spans = {}, {}
        for match in FIELD.finditer(block):
            fields[match[1]] = float(match[2])
            spans[match[1]] = (start + match.start(2), start + match.end(2))
        spot = None
        joints = tuple(key for key in JOINTS if key in spans)  # of smaller arms fewer
        for keys in (joints, tuple(POSE)):
            if keys and set(keys) <= spans.keys():
                spot = Spot(self.file, tuple(spans[key] for key in keys))
        numbers = [re.search(rf"{name}\s*:\s*(\d+|F)", block) for name in ("UF", "UT")]
        frame, tool = ((None if match[1] == "F" else int(match[1])) if match else 0 for match in numbers)
        said = re.search(r"CONFIG\s*:\s*'([^']*)'", block)
        return _Position(fields, spot, frame, tool, of_fanuc(said[1]) if said else None)

    def read(self, line: str) -> None:
        if match := re.match(rf"WAIT\s+({NUMBER})\s*\(?sec", line, re.I):
            self.motions.wait(float(match[1]))
        elif match := re.match(rf"PR\[(\d+),(\d)[^\]]*\]\s*=\s*\(?({NUMBER})\)?$", line, re.I):
            self.registers.setdefault(match[1], {})[int(match[2])] = float(match[3])
        elif match := re.match(r"PR\[(\d+)[^\]]*\]\s*=\s*LPOS$", line, re.I):
            self.registers[match[1]] = {}
        elif match := re.match(r"(UTOOL|UFRAME)\[(\d+)[^\]]*\]\s*=\s*PR\[(\d+)", line, re.I):
            said = self.registers.get(match[3], {})
            if set(range(1, 7)) <= said.keys():
                frame = Frame(_pose([said[k] for k in range(1, 7)]))
                self.frames[match[1].upper(), int(match[2])] = frame
        elif match := NUMBERED.match(line):
            kind = match[1].upper()
            self.in_force[KINDS.get(kind, kind)] = int(match[2]) if match[2] else None
        elif match := MOVE.match(line):
            if SHIFTED.search(line, match.end()):
                what = f"{line.split(']')[0]}] with an offset cannot be read"
                self.motions.fault(int(self.motions.line), what, "give the position without it")
            else:
                self._move(match)
        elif UNREAD.match(line):
            mend = "give the path as L P[..] or C P[..] P[..] with positions in the file"
            self.motions.fault(int(self.motions.line), f"{line!r} cannot be read", mend)

    def _move(self, match: re.Match[str]) -> None:
        kind, pace, unit = match[1].upper(), match[6], (match[7] or "").lower()
        named = [(match[2], match[3])] + ([(match[4], match[5])] if match[5] else [])
        register, index = named[-1]
        position = self.positions.get(index)
        told = f"{kind} {register}[{index}]"
        if (
            kind == "A"
            or (kind == "C") != (len(named) == 2)
            or any(name.upper() == "PR" for name, _ in named)
        ):
            mend = "give the path as L P[..] or C P[..] P[..] with positions in the file"
            self.motions.fault(int(self.motions.line), f"{told} cannot be read", mend)
            return
        if position is None:
            self.motions.fault(
                int(self.motions.line), f"{told} has no position cannot be read", "give it in /POS"
            )
            return
        if computed := [number for _, number in named if number in self.computed]:
            what = f"P[{computed[0]}] is set in the program"
            self.motions.fault(int(self.motions.line), what, "give its numbers in /POS alone")
            return
        fields, spot = position.fields, position.spot
        rails = tuple(1e-3 * fields[f"E{i}"] for i in (1, 2, 3) if f"E{i}" in fields)
        value = float(pace) if pace else np.nan
        share, duration = value / 100 if unit == "%" else np.nan, value * SECONDS.get(unit, np.nan)
        if spot is not None and "J1" in fields:
            arm = tuple(np.radians([fields[key] for key in JOINTS if key in fields]))
            self.motions.joints(arm, rails, share, duration, spot=spot)
        elif spot is not None:
            self._frame("base", "UFRAME", position.frame)
            self._frame("tool", "UTOOL", position.tool)
            over = self.positions.get(named[0][1]) if kind == "C" else None
            ending = (match[8] or "FINE").upper()
            self.motions.pose(
                _pose([fields[key] for key in POSE]),
                rails,
                value * METRES.get(unit, np.nan),
                np.radians(value) if unit == "deg/sec" else np.nan,
                duration,
                1e-3 if ending.startswith("CNT") and int(ending[3:]) > 0 else 0.0,
                share=share,
                via=_pose([over.fields[key] for key in POSE]) if over and over.spot else None,
                spot=spot,
                via_spot=over.spot if over else None,
                free=kind == "J",
                posture=position.posture,
            )
        else:
            what = f"P[{index}] is no whole position (X Y Z W P R or J1..J6)"
            self.motions.fault(int(self.motions.line), what)

    def _frame(self, name: str, kind: str, number: int | None) -> None:
        number = self.in_force.get(kind) if number is None else number
        if number is None:
            self.motions.elsewhere(name, f"{kind} in force")
        elif (kind, number) in self.frames:
            setattr(self.motions, name, self.frames[kind, number])
        else:
            self.motions.elsewhere(name, f"{kind}[{number}]")


def _pose(numbers: list[float]) -> Array:
    """(4, 4) from x y z [mm] and w p r [deg]."""
    turn = rotations.from_zyx(np.radians([numbers[:2:-1]]))
    return rotations.pose(1e-3 * np.array([numbers[:3]]), turn)[0]
