"""Stäubli VAL 3, written: an application of XML files, the points in an array and a loop that goes through
them (with circles: a line for each). `val3_read.py` reads it.

Conventions of the VAL 3 reference manual: mm and degrees, R = Rx(rx) Ry(ry) Rz(rz), the other order
than KUKA's; a motion descriptor says tool speed `tmax` [mm/s], turning speed `rmax` [deg/s], joint
speed `vel` [%] and the corner (`leave`, `reach`) [mm]. Names shorter than 16 characters; arrays of at
most 9999 entries. The arm keeps its posture (ssame, esame, wsame). Joint moves have no times, only a share
of the full speed; loads are set on the controller. Four files: name.pjx (project), name.dtx (data),
start.pgx and stop.pgx (programs).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ...robot import rotations
from .base import Array, Program
from .format import Format, by_angles
from .motions import Motions
from .near import near_zyx
from .val3_read import VAL3_FREE, scan

SPACE = "http://www.staubli.com/robotics/VAL3"  # names of the XML vocabularies, not addresses
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
XML_HEAD = '<?xml version="1.0" encoding="utf-8"?>'
SPEED_DIGITS = 6
VAL3_WORDS = """
abs accel and begin blend bnot bor bxor call case default delay do else elseif end endfor endif
endswitch endwhile false for if mod movec movej movel next not or return start step stop switch then to
true until waitendmove while xor"""
Row = dict[str, str]
WORLD, BASE = "world[0]", "fBase[0]"


class Val3(Format):
    name, title, extension = "val3", "Stäubli VAL 3", ".pjx"
    mm_digits = 4
    longest_name = 15
    reserved = frozenset(VAL3_WORDS.split())
    most_points = 9999
    named_as_file = True
    circles = True
    makers = ("stäubli", "staubli")
    own_folder = True

    def warnings(self, program: Program) -> list[str]:
        found = super().warnings(program)
        if program.kind == "joints" and program.time is not None:
            found.append(f"joint moves have no times: the arm goes at {100 * program.share:g} % of its speed")
        if program.load is not None:
            x, y, z = program.load.com_mm
            what = f"{program.load.mass_kg:.3f} kg at {x:.1f}, {y:.1f}, {z:.1f} mm"
            found.append(f"the load ({what}) has to be set on the controller: the application cannot")
        return found

    def printed(self, X: Array) -> Array:
        return by_angles(X, rotations.xyz_angles, rotations.from_xyz, self.mm_digits, self.deg_digits)

    def write(self, program: Program) -> dict[str, str]:
        joints = program.kind == "joints"
        points = [self._joints(arm) for arm in program.arm] if joints else self._poses(program)
        kind, name = ("jointRx", "jPath") if joints else ("pointRx", "pPath")
        pauses = self.legs(program).pause if not joints else program.dwell
        data = [
            _array("tTool", "tool", [self._frame(program.tool) | {"fatherId": "flange[0]"}]),
            _array(name, kind, points),
            _array("mPath", "mdesc", self._descriptors(program)),
            _array("mStart", "mdesc", [_descriptor(program.share)]),
        ]
        if not program.in_world:
            data.append(_array("fBase", "frame", [self._frame(program.base) | {"fatherId": WORLD}]))
        if program.circular.any():
            data.append(
                _array("pVia", "pointRx", self._points(program, program.via_in_base, program.circular))
            )
        if not joints and program.arm.shape[1] == 6:
            data.append(_array("jStart", "jointRx", [self._joints(program.arm[0])]))
        if pauses.any():
            data.append(_array("nPause", "num", [{"value": f"{pause:.3f}"} for pause in pauses]))
        files = {f"{program.name}.pjx": _project(program.name), f"{program.name}.dtx": _database(data)}
        files["start.pgx"] = _program("start", self._start(program, name, pauses))
        return files | {"stop.pgx": _program("stop", ["resetMotion()"], local=False)}

    def _frame(self, X: Array) -> Row:
        angles = np.degrees(rotations.xyz_angles(X[None, :3, :3])[0])
        place = {n: f"{1e3 * v:z.{self.mm_digits}f}" for n, v in zip("xyz", X[:3, 3], strict=True)}
        return place | {f"r{n}": f"{v:z.{self.deg_digits}f}" for n, v in zip("xyz", angles, strict=True)}

    def _poses(self, program: Program) -> list[Row]:
        return self._points(program, program.in_base, np.ones(program.count, dtype=bool))

    def _points(self, program: Program, X: Array, used: NDArray[np.bool_]) -> list[Row]:
        posture = {"shoulder": "ssame", "elbow": "esame", "wrist": "wsame"}
        posture["fatherId"] = WORLD if program.in_world else BASE
        return [(self._frame(pose) if use else {}) | posture for pose, use in zip(X, used, strict=True)]

    def _joints(self, arm: Array) -> Row:
        return {f"j{i}": f"{np.degrees(value):z.{self.deg_digits}f}" for i, value in enumerate(arm, 1)}

    def _descriptors(self, program: Program) -> list[Row]:
        if program.kind == "joints":
            blends = np.where(program.passing, 1e3 * program.blend, 0.0)
            return [_descriptor(program.share, blend=blend, kind="joint") for blend in blends]
        legs, rows = self.legs(program), []
        for i in range(program.count):
            speed = 1e3 * legs.speed[i] if np.isfinite(legs.speed[i]) else 100.0
            turn = np.degrees(legs.turn[i]) if legs.turning[i] else VAL3_FREE
            rows.append(_descriptor(1.0, speed, turn, 1e3 * legs.blend[i]))
        return rows

    def _start(self, program: Program, name: str, pauses: Array) -> list[str]:
        """By joints to the start where they are known, else by joint motion to the first pose."""
        first, lines = 0, [f"// {note}" for note in program.notes]
        move = "movej" if program.kind == "joints" else "movel"
        if program.kind == "poses" and program.arm.shape[1] == 6:
            lines += ["movej(jStart,tTool,mStart)", "waitEndMove()"]
        elif program.kind == "poses":
            wait = ["waitEndMove()", "delay(nPause[0])"] if pauses[0] > 0 else []
            lines, first = [*lines, f"movej({name}[0],tTool,mStart)", *wait], 1
        if program.circular.any():
            for i in range(first, program.count):
                target = f"{name}[{i}],tTool,mPath[{i}])"
                lines.append(f"movec(pVia[{i}],{target}" if program.circular[i] else f"{move}({target}")
                lines += ["waitEndMove()", f"delay(nPause[{i}])"] if pauses[i] > 0 else []
            return [*lines, "waitEndMove()"]
        index = "l_nIndex"
        pause = [f"  if nPause[{index}]>0", "    waitEndMove()", f"    delay(nPause[{index}])", "  endIf"]
        return [
            *lines,
            f"for {index}={first} to {program.count - 1}",
            f"  {move}({name}[{index}],tTool,mPath[{index}])",
            *(pause if pauses.any() else []),
            "endFor",
            "waitEndMove()",
        ]

    def numbers(self, X: Array, like: Array) -> Array:
        angles = rotations.xyz_angles(X[None, :3, :3])[0]
        return np.concatenate([1e3 * X[:3, 3], np.degrees(near_zyx(angles, np.radians(like[3:])))])

    def scan(self, files: Mapping[str, str]) -> Motions:
        return scan(files)


def _descriptor(
    share: float,
    speed: float = VAL3_FREE,
    turn: float = VAL3_FREE,
    blend: float = 0.0,
    kind: str = "Cartesian",
) -> Row:
    corner = f"{blend:.3f}"
    row = {"accel": "100", "vel": f"{100 * share:.{SPEED_DIGITS}g}", "decel": "100"}
    row |= {"tmax": f"{speed:.{SPEED_DIGITS}f}", "rmax": f"{turn:.{SPEED_DIGITS}f}"}
    return row | {"blend": kind if blend > 0 else "off", "leave": corner, "reach": corner}


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
