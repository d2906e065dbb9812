"""The joint positions of a robot program as a table: `template = "rapid"`, `"krl"` ... in `[poses]`.

A row per position, on the line where it begins, so that faults name the program's own lines: its name, then
its axes in degrees, of URScript in radians (external ones as they stand). Without names the rows are
numbered.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from ..files.faults import Fault, InputError
from ..files.program_text import NO_AXIS, NUMBER, code_of

ARM = 6  # axes that these languages state before the external ones

Position = tuple[int, str, list[str]]  # where it begins in the text, its name or nothing, its axes

_SIX = rf"\[\s*({NUMBER}(?:\s*,\s*{NUMBER}){{{ARM - 1}}})\s*\]"
_RAPID = re.compile(rf"(?:\bjointtarget\s+(\w+)\s*:=\s*)?\[\s*{_SIX}\s*,\s*{_SIX}\s*\]", re.I)
_KRL = re.compile(rf"(?:\b(?:E[36]?)?AXIS\s+(\w+)\s*=\s*)?\{{([^{{}}]*\bA1\s+{NUMBER}[^{{}}]*)\}}", re.I)
_FIELD = re.compile(rf"\b([AE]\d)\s+({NUMBER})", re.I)
_LS = re.compile(
    r"\bP\[\s*(?P<p>\d+)[^\]]*\]\s*\{(?P<taught>[^{}]*\bJ1\s*=[^{}]*)\}"
    r"|\[\s*1\s*,\s*(?P<pr>\d+)\s*\]\s*=\s*'[^'\n]*'\s*Group:\s*1\s+(?P<register>J1\s*=[^\[]*)",
    re.I,
)
_LS_FIELD = re.compile(rf"\b([JE])(?:XT)?(\d)\s*[=:]\s*({NUMBER})", re.I)
_VAL3 = re.compile(r"<Value\b[^<>]*\bj1=[^<>]*>")
_VAL3_FIELD = re.compile(rf'\bj(\d)="({NUMBER})"')
_JOINT_LIST = rf"({NUMBER}(?:\s*,\s*{NUMBER}){{{ARM - 1}}})\s*"
_URSCRIPT = re.compile(rf"(?:\b(\w+)\s*=|\bmove[jl]\s*\()\s*\[\s*{_JOINT_LIST}\]")
_DRL = re.compile(rf"(?:\b(\w+)\s*=\s*)?\bposj\s*\(\s*{_JOINT_LIST}\)")
_PULSES = re.compile(r"^///(POSTYPE\s+)?PULSE\b", re.M)
_TOOL_POSES = re.compile(
    r"\bmove[jlp]\s*\(\s*p\[|=\s*p\["  # URScript
    r"|^///POSTYPE\s+(BASE|ROBOT|M?TOOL|USER)"  # JBI
    r"|\bposx\s*\("  # DRL
    r"|\brobtarget\b|\bE[36]?POS\b|\{\s*X\s+[-+\d]|\bX\s*[:=]\s*[-+.\d]+[\s,m]+Y\s*[:=]",
    re.I | re.M,
)


def _rapid(text: str) -> Iterator[Position]:
    for match in _RAPID.finditer(code_of(text, "!")):
        arm, external = ([cell.strip() for cell in match[i].split(",")] for i in (2, 3))
        yield match.start(), match[1] or "", [*arm, *(cell for cell in external if float(cell) < NO_AXIS)]


def _krl(text: str) -> Iterator[Position]:
    for match in _KRL.finditer(code_of(text, ";")):
        said = {key.upper(): value for key, value in _FIELD.findall(match[2])}
        arm = [said.pop(f"A{i}", "") for i in range(1, ARM + 1)]
        yield match.start(), match[1] or "", [*arm, *(said[key] for key in sorted(said) if key[0] == "E")]


def _ls(text: str) -> Iterator[Position]:
    for match in _LS.finditer(text):
        fields = _LS_FIELD.findall(match["taught"] or match["register"])
        said = {f"{key}{number}".upper(): value for key, number, value in fields}
        arm = [said.pop(f"J{i}", "") for i in range(1, ARM + 1)]
        name = f"P{match['p']}" if match["p"] else f"PR{match['pr']}"
        yield match.start(), name, [*arm, *(said[key] for key in sorted(said))]


def _val3(text: str) -> Iterator[Position]:
    for match in _VAL3.finditer(text):
        said = dict(_VAL3_FIELD.findall(match[0]))
        yield match.start(), "", [said.get(str(i), "") for i in range(1, ARM + 1)]


def _listed(pattern: re.Pattern[str], text: str) -> Iterator[Position]:
    for match in pattern.finditer(code_of(text, "#")):
        yield match.start(), match[1] or "", [cell.strip() for cell in match[2].split(",")]


PROGRAMS: dict[str, Callable[[str], Iterator[Position]]] = {
    "rapid": _rapid,
    "krl": _krl,
    "ls": _ls,
    "val3": _val3,
    "urscript": partial(_listed, _URSCRIPT),
    "drl": partial(_listed, _DRL),
}
SAID = {  # how each says them, for messages
    "rapid": "jointtarget p1 := [[0,10,20,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]]; a robtarget says no joints",
    "krl": "{A1 0,A2 -90,A3 90,A4 0,A5 30,A6 0}; E6POS and X, Y, Z, A, B, C say no joints",
    "ls": "P[1]{ GP1: J1= 0.0 deg, ... }, or joints in POSREG.VA; X, Y, Z, W, P, R say no joints",
    "val3": '<Value key="0" j1="0" j2="-90" ... /> of a .dtx; points say no joints',
    "urscript": "movej([0, -1.57, 1.57, 0, 1.57, 0], ...) or p1 = [...]; p[...] says no joints",
    "drl": "posj(0, 0, 90, 0, 90, 0); posx says no joints",
}


def joint_table(text: str, program: str, path: Path) -> str:
    """The text of a table without header: the name of each position and its axes.

    program: a name of `PROGRAMS`. Raises `InputError` where there is none, or two on a line.
    """
    found = list(PROGRAMS[program](text))
    if not found:
        raise InputError(Fault(str(path), f"has no joint positions as {program} says them", SAID[program]))
    named = all(name for _, name, _ in found)
    most = max(len(axes) for _, _, axes in found)
    rows = [""] * (text.count("\n") + 1)
    for number, (start, name, axes) in enumerate(found, 1):
        line = text.count("\n", 0, start)
        if rows[line]:
            fault = Fault(f"{path} line {line + 1}", "has two joint positions", "give each a line of its own")
            raise InputError(fault)
        rows[line] = ",".join([name if named else str(number), *axes, *[""] * (most - len(axes))])
    return "\n".join(rows)


def program_of(text: str) -> str | None:
    """Which program's joint positions a text holds; None: it is no such program."""
    return next((name for name, positions in PROGRAMS.items() if any(True for _ in positions(text))), None)


def no_joints(text: str) -> str:
    """Why a text that looks like a program says no joints; nothing where it does not look so."""
    if _PULSES.search(text):
        return "its positions are pulses of the motors: write them in degrees, a row per pose"
    if _TOOL_POSES.search(text):
        return "its positions are the tool's, which say no joints: export jointtargets (RAPID), axes (KRL)"
    return ""
