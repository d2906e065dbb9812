"""Stäubli VAL 3: an application of XML files, the points in an array, one loop that goes through them.

Conventions of the VAL 3 reference manual: mm and degrees, R = Rx(rx) Ry(ry) Rz(rz), the other order
than KUKA's; a motion descriptor says tool speed `tmax` [mm/s], turning speed `rmax` [deg/s], joint
speed `vel` [%] and the corner (`leave`, `reach`) [mm]. Names shorter than 16 characters; arrays of at
most 9999 entries. The frame `world` has to be the model's base. The arm keeps its posture (ssame, esame,
wsame). Four files: name.pjx (project), name.dtx (data), start.pgx and stop.pgx (programs).
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping

import numpy as np

from ...files.faults import Fault, InputError
from ...robot import rotations
from .base import Array, Program, legs_of
from .format import Format
from .motions import Motions

SPACE = "http://www.staubli.com/robotics/VAL3"  # names of the XML vocabularies, not addresses
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
XML_HEAD = '<?xml version="1.0" encoding="utf-8"?>'
VAL3_FREE = 99999.0  # mm/s, deg/s: does not limit
VAL3_WORDS = """
abs accel and begin blend bnot bor bxor call case default delay do else elseif end endfor endif
endswitch endwhile false for if mod movec movej movel next not or return start step stop switch then to
true until waitendmove while xor"""
Row = dict[str, str]


class Val3(Format):
    name, title, extension = "val3", "Stäubli VAL 3", ".pjx"
    mm_digits = 4
    longest_name = 15
    reserved = frozenset(VAL3_WORDS.split())
    most_points = 9999
    named_as_file = True

    def write(self, program: Program) -> dict[str, str]:
        joints = program.kind == "joints"
        points = [self._joints(arm) for arm in program.arm] if joints else self._poses(program)
        kind, name = ("jointRx", "jPath") if joints else ("pointRx", "pPath")
        pauses = legs_of(program).pause if not joints else program.dwell
        data = [
            _array("tTool", "tool", [self._frame(program.tool) | {"fatherId": "flange[0]"}]),
            _array(name, kind, points),
            _array("mPath", "mdesc", self._descriptors(program)),
            _array("mStart", "mdesc", [_descriptor(program.share)]),
        ]
        if not joints and program.arm.shape[1] == 6:
            data.append(_array("jStart", "jointRx", [self._joints(program.arm[0])]))
        if pauses.any():
            data.append(_array("nPause", "num", [{"value": f"{pause:.3f}"} for pause in pauses]))
        files = {f"{program.name}.pjx": _project(program.name), f"{program.name}.dtx": _database(data)}
        files["start.pgx"] = _program("start", self._start(program, name, bool(pauses.any())))
        return files | {"stop.pgx": _program("stop", ["resetMotion()"], local=False)}

    def _frame(self, X: Array) -> Row:
        angles = np.degrees(rotations.xyz_angles(X[None, :3, :3])[0])
        place = {n: f"{1e3 * v:z.{self.mm_digits}f}" for n, v in zip("xyz", X[:3, 3], strict=True)}
        return place | {f"r{n}": f"{v:z.{self.deg_digits}f}" for n, v in zip("xyz", angles, strict=True)}

    def _poses(self, program: Program) -> list[Row]:
        assert program.X is not None
        posture = {"shoulder": "ssame", "elbow": "esame", "wrist": "wsame", "fatherId": "world[0]"}
        return [self._frame(X) | posture for X in program.X]

    def _joints(self, arm: Array) -> Row:
        return {f"j{i}": f"{np.degrees(value):z.{self.deg_digits}f}" for i, value in enumerate(arm, 1)}

    def _descriptors(self, program: Program) -> list[Row]:
        if program.kind == "joints":
            return [_descriptor(program.share)] * program.count
        legs, rows = legs_of(program), []
        for i in range(program.count):
            speed = 1e3 * legs.speed[i] if np.isfinite(legs.speed[i]) else 100.0
            turn = np.degrees(legs.turn[i]) if legs.turning[i] else VAL3_FREE
            rows.append(_descriptor(1.0, speed, turn, 1e3 * legs.blend[i]))
        return rows

    def _start(self, program: Program, name: str, pauses: bool) -> list[str]:
        """By joints to the start where they are known, else by joint motion to the first pose."""
        move, first, lines = "movel", 0, []
        pause = ["if nPause[{0}]>0", "  waitEndMove()", "  delay(nPause[{0}])", "endIf"] if pauses else []
        if program.kind == "joints":
            move = "movej"
        elif program.arm.shape[1] == 6:
            lines = ["movej(jStart,tTool,mStart)", "waitEndMove()"]
        else:
            lines, first = [f"movej({name}[0],tTool,mStart)", *(line.format(0) for line in pause)], 1
        lines += [
            f"for l_nIndex={first} to {program.count - 1}",
            f"  {move}({name}[l_nIndex],tTool,mPath[l_nIndex])",
        ]
        return [*lines, *(f"  {line.format('l_nIndex')}" for line in pause), "endFor", "waitEndMove()"]

    def read(self, files: Mapping[str, str]) -> Program:
        return _Reader(files).program()


def _descriptor(share: float, speed: float = VAL3_FREE, turn: float = VAL3_FREE, blend: float = 0.0) -> Row:
    corner = f"{blend:.3f}"
    row = {"accel": "100", "vel": f"{100 * share:g}", "decel": "100"}
    row |= {"tmax": f"{speed:.4f}", "rmax": f"{turn:.4f}"}
    return row | {"blend": "Cartesian" if blend > 0 else "off", "leave": corner, "reach": corner}


def _array(name: str, kind: str, rows: list[Row]) -> str:
    head = f'    <Data name="{name}" access="private" xsi:type="array" type="{kind}" size="{len(rows)}">'
    texts = [" ".join(f'{key}="{value}"' for key, value in row.items()) for row in rows]
    values = [f'      <Value key="{i}" {text} />' for i, text in enumerate(texts)]
    return "\n".join([head, *values, "    </Data>"])


def _database(data: list[str]) -> str:
    head = [XML_HEAD, f'<Database {XSI} xmlns="{SPACE}/Data/2">', "  <Datas>"]
    return "\n".join([*head, *data, "  </Datas>", "</Database>", ""])


def _project(name: str) -> str:
    lines = [
        *(XML_HEAD, f'<Project xmlns="{SPACE}/Project/3">'),
        '  <Parameters version="s7.3.1" stackSize="5000" millimeterUnit="true" />',
        *(
            "  <Programs>",
            '    <Program file="start.pgx" />',
            '    <Program file="stop.pgx" />',
            "  </Programs>",
        ),
        *(
            "  <Database>",
            f'    <Data file="{name}.dtx" />',
            "  </Database>",
            "  <Libraries />",
            "</Project>",
            "",
        ),
    ]
    return "\n".join(lines)


def _program(name: str, code: list[str], local: bool = True) -> str:
    index = [
        "    <Locals>",
        '      <Local name="l_nIndex" type="num" xsi:type="array" size="1" />',
        "    </Locals>",
    ]
    head = [XML_HEAD, f'<Programs {XSI} xmlns="{SPACE}/Program/2">', f'  <Program name="{name}">']
    body = ["    <Code><![CDATA[begin", *(f"  {line}" for line in code), "end]]></Code>"]
    return "\n".join([*head, *(index if local else []), *body, "  </Program>", "</Programs>", ""])


class _Reader:
    """Data by name, then the moves of the programs in their order; a loop stands for its whole array."""

    def __init__(self, files: Mapping[str, str]) -> None:
        project = next((name for name in files if name.lower().endswith(".pjx")), next(iter(files)))
        self.motions = Motions(project)
        self.motions.name = re.sub(r"\.\w+$", "", project)
        trees = {name: _tree(name, text) for name, text in files.items()}
        self.rows: dict[str, dict[int, Row]] = {}
        for tree in trees.values():
            for item in tree.iter():
                if _tag(item) == "Data" and "name" in item.attrib:
                    values = [value for value in item if _tag(value) == "Value"]
                    self.rows[item.get("name", "")] = {int(v.get("key", "0")): dict(v.attrib) for v in values}
        self.code = [(name, item.text or "") for name, tree in trees.items() if name.lower().endswith(".pgx")
                     for item in tree.iter() if _tag(item) == "Code"]  # fmt: skip

    def program(self) -> Program:
        for name, code in self.code:
            self._block([re.sub(r"//.*", "", line).strip() for line in code.splitlines()], name, {})
        return self.motions.program()

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
            elif match := re.match(r"(move[jlc])\s*\(([^,]+),([^,]+),([^,]+)\)", line, re.I):
                self._move(place, match[1].lower(), (match[2], match[3], match[4]), index)
            elif match := re.match(r"delay\s*\((.+)\)", line, re.I):
                self.motions.wait(self._number(match[1], index))
            i += 1

    def _row(self, text: str, index: Mapping[str, int]) -> Row | None:
        match = re.fullmatch(r"\s*(\w+)\s*(?:\[\s*(\w+)\s*\])?\s*", text)
        if match is None:
            return None
        key = match[2] or "0"
        return self.rows.get(match[1], {}).get(index.get(key, int(key) if key.isdigit() else -1))

    def _number(self, text: str, index: Mapping[str, int]) -> float:
        row = self._row(text, index)
        return float(row.get("value", "0") if row is not None else text)

    def _move(self, place: str, kind: str, said: tuple[str, str, str], index: Mapping[str, int]) -> None:
        """One motion: point (or joints), tool and motion descriptor."""
        target = said[0].strip()
        row, frame, pace = (self._row(text, index) for text in said)
        pace = pace or {}
        if row is None or kind == "movec":
            self.motions.fault(
                place, f"{kind}({target}, ...) cannot be read", "give points as data of the application"
            )
            return
        if any(key.startswith("j") for key in row):
            arm = tuple(np.radians(float(row.get(f"j{i}", "0"))) for i in range(1, 7))
            self.motions.joints(arm, share=float(pace.get("vel", 100.0)) / 100)
            return
        if row.get("fatherId", "world[0]") not in ("world[0]", "world"):
            self.motions.fault(place, f"{target} stands in {row['fatherId']}", "give points in world")
        if frame is not None:
            self.motions.tool = _read_frame(frame)
        limits = [float(pace.get(key, VAL3_FREE)) for key in ("tmax", "rmax")]
        speed, turn = (limit if kind == "movel" and limit < VAL3_FREE else np.nan for limit in limits)
        blend = float(pace.get("leave", 0.0)) if pace.get("blend", "off").lower() != "off" else 0.0
        self.motions.pose(_read_frame(row), (), 1e-3 * speed, np.radians(turn), blend=1e-3 * blend)


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
