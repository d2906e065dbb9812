"""ABB RAPID, read: the moves of a module with the targets, tools and work objects that it declares."""

from __future__ import annotations

import re
from bisect import bisect
from collections.abc import Mapping

import numpy as np

from ...files.program_text import NO_AXIS, code_of
from ...robot import rotations
from ...robot.schema import LoadData
from .base import Array
from .format import NUMBER
from .motions import NONE, Frame, Motions, Spot
from .posture import of_abb
from .text import arguments

RAPID_FULL_JOINT_SPEED = 1000.0  # mm/s at the tool that counts as full speed of a joint move
MOVE = re.compile(r"\b(MoveL|MoveJ|MoveAbsJ|MoveC)(?:DO|AO|GO|Sync)?(?:\s+|(?=\\))", re.I)
UNREAD = re.compile(
    r"(?<![\w\\.])(W?Arc[LC]\d?(?:Start|End)?|Trigg(?:L|J|C|LIOs)|Search[LC]|MoveExtJ|"
    r"(?:Spot|Paint|Disp|Cap|Contact)[LJC])(?=[\s\\])(?!\s*:=)",
    re.I,
)
SHIFTED = re.compile(r"\b((?:PDisp|EOffs)(?:On|Set|Add))\b", re.I)
SET = re.compile(r"(?<![\w\\.])(\w+)\s*(?:\{[^}]*\})?(?:\.\w+)*\s*:=")  # no option
GIVEN = re.compile(r"\b(?:CONST|VAR|PERS)\s+\w+\s+\w+\s*(?:\{[^}]*\}\s*)?:=", re.I)
EMPTY = re.compile(r"\b(?:VAR|PERS)\s+\w+\s+(\w+)\s*$", re.I)  # declared without a value
TAKES = re.compile(r"\b(?:PROC|FUNC\s+\w+)\s+\w+\s*\(([^)]*)\)", re.I)
DECLARED = re.compile(
    r"\b(robtarget|jointtarget|tooldata|wobjdata|speeddata|zonedata)\s+(\w+)\s*:=\s*(\[.*\])", re.I | re.S
)

# between these, in turn: the module's data, and a routine's own
ROUTINE = re.compile(r"\b(?:PROC|FUNC|TRAP|ENDPROC|ENDFUNC|ENDTRAP)\b", re.I)

Text = tuple[int, str]  # where the text begins in the file, the text
Key = tuple[int, str]  # routine and name
NOTHING = (0, "")


def scan(files: Mapping[str, str]) -> Motions:
    """The motions of a module, with the places of their numbers."""
    file, text = next(iter(files.items()))
    code = code_of(text, "!")
    reader = _Reader(file, Motions(file))
    if match := re.search(r"^\s*MODULE\s+(\w+)", code, re.I | re.M):
        reader.motions.name = match[1]
    statements = [(match.start(), match[0]) for match in re.finditer(r"[^;]+", code)]
    bounds = [match.start() for match in ROUTINE.finditer(code)]
    for start, statement in statements:
        if match := DECLARED.search(statement):
            at = start + match.start(3)
            reader.declare(bisect(bounds, at), match[2], (at, match[3]))
        elif match := EMPTY.search(statement):
            reader.declare(bisect(bounds, start + match.start()), match[1], NOTHING)
    for match in TAKES.finditer(code):
        for name in re.findall(r"(\w+)\s*(?:\{[^}]*\})?\s*(?:[,|]|$)", match[1]):
            reader.declare(bisect(bounds, match.start()), name, NOTHING)
    for start, statement in statements:
        for match in () if GIVEN.search(statement) else SET.finditer(statement):
            reader.computed.add(reader.key(match[1], bisect(bounds, start + match.start(1))))
    shifted = -1  # the routine in which targets are
    for start, statement in statements:
        match = MOVE.search(statement) or UNREAD.search(statement) or SHIFTED.search(statement)
        if match:
            reader.routine = bisect(bounds, start + match.start(1))
            reader.motions.line = code.count("\n", 0, start + match.start(1)) + 1
        if match and match.re is SHIFTED:
            shifted = reader.routine
            reader.motions.remark(f"{match[1]} shifts targets: those of other routines are taken without")
        elif re.search(r"\b(?:PDisp|EOffs)Off\b", statement, re.I):
            shifted = -1
        elif match and (match.re is UNREAD or (reader.routine == shifted and match[1].lower() != "moveabsj")):
            what = "cannot be read" if match.re is UNREAD else "goes to a shifted target"
            reader.motions.fault(int(reader.motions.line), f"{match[1]} {what}", "export the path anew")
        elif match:
            reader.move(match[1].lower(), start + match.end(), statement[match.end() :])
        elif match := re.search(r"\bConf(J|L)\s*\\(On|Off)\b", statement, re.I):
            reader.obeyed[match[1].upper()] = match[2].lower() == "on"
        elif re.search(r"\bGripLoad\s+(?!load0\b)", statement, re.I):
            reader.motions.line = code.count("\n", 0, start + len(statement)) + 1
            reader.motions.remark("GripLoad: this load is not counted, only that of the tool")
        elif match := re.search(r"\bWaitTime(?:\s*\\InPos\s*,)?\s*([\d.]+)", statement, re.I):
            reader.motions.wait(float(match[1]))
    return reader.motions


class _Reader:
    """Reads one move at a time, with the data that the module declares."""

    def __init__(self, file: str, motions: Motions) -> None:
        self.file, self.motions = file, motions
        self.declared: dict[Key, Text] = {}
        self.shared: dict[str, Key] = {}  # those of the module by their name
        self.computed: set[Key] = set()  # data that the program sets
        self.routine = 0
        self.obeyed = {"J": True, "L": True}  # ConfJ and ConfL

    def move(self, kind: str, start: int, text: str) -> None:
        """Targets, speed, zone and tool."""
        parts = [(start + place, part) for place, part in arguments(text)]
        if parts and parts[0][1].startswith("\\"):  # \Conc
            parts = parts[1:]
        ends, line = (2 if kind == "movec" else 1), int(self.motions.line)
        if len(parts) < ends + 3:
            self.motions.fault(line, f"{kind} cannot be read", "give target, speed, zone and tool")
            return
        targets = [self._target(*part) for part in parts[:ends]]
        for (_, name), found in zip(parts, targets, strict=False):
            computed = self._is_computed(name)
            if found is None or computed:
                if "(" in name:
                    what, mend = f"{name!r} is computed", "give its numbers"
                elif computed:
                    what, mend = f"{name!r} is set in the program", "give its numbers"
                else:
                    what, mend = f"no target {name!r} declared", "declare it in this module"
                self.motions.fault(line, what, mend)
                return
        speed, zone, tool = (part for _, part in parts[ends : ends + 3])
        moved = self._frames(tool, ",".join([tool, *(part for _, part in parts[ends + 3 :])]))
        if moved:
            self.motions.fault(line, moved, "export the path anew")
            return
        said = re.search(r"\\T\s*:=\s*([\d.]+)", speed, re.I)
        duration = float(said[1]) if said else np.nan
        (numbers, spans), *_ = [found for found in targets[-1:] if found]
        if kind == "moveabsj":
            share = np.nan if said else self._speed(speed) / RAPID_FULL_JOINT_SPEED
            arm = tuple(np.radians(numbers[:6]))
            spot = Spot(self.file, tuple(spans[:6]))
            self.motions.joints(arm, _rails(numbers[6:]), share, duration, spot=spot)
            return
        for found in targets:
            if found and (len(found[0]) != 17 or not 0.99 < np.linalg.norm(found[0][3:7]) < 1.01):
                self.motions.fault(line, "no whole robtarget with a quaternion of length 1")
                return
        over = targets[0] if kind == "movec" else None
        free = kind == "movej"
        corner = re.search(r"\\Z\s*:=\s*([\d.]+)", zone, re.I) or re.fullmatch(r"z(\d+)", zone, re.I)
        self.motions.pose(
            _frame(numbers),
            _rails(numbers[11:]),
            np.nan if free else 1e-3 * self._speed(speed),
            duration=duration,
            blend=1e-3 * float(corner[1]) if corner else 0.0,
            share=self._speed(speed) / RAPID_FULL_JOINT_SPEED if free else np.nan,
            via=_frame(over[0]) if over else None,
            spot=Spot(self.file, tuple(spans[:7])),
            via_spot=Spot(self.file, tuple(over[1][:7])) if over else None,
            free=free,
            posture=of_abb(numbers[7:11], self.obeyed["J" if free else "L"]),
        )

    def _frames(self, tool: str, options: str) -> str:
        """Tool and work object of a move; what cannot be read of them, "" where all can."""
        name = tool.split("\\")[0].strip().lower()
        wobj = re.search(r"\\WObj\s*:=\s*(\w+)", options, re.I)
        base = wobj[1].lower() if wobj else "wobj0"
        computed = [one for one in (name, base) if self._is_computed(one)]
        if computed:
            return f"{computed[0]!r} is set in the program"
        if name == "tool0":
            self.motions.tool, self.motions.load = NONE, None
        elif (found := self._numbers(*self._text(0, name))) is not None and len(found[0]) >= 11:
            numbers = found[0]
            if self._flags(name)[:1] == ["FALSE"]:
                return f"tool {name!r} stands still, and the robot holds the work object"
            self.motions.tool = Frame(_frame(numbers))
            known = numbers[7] > 0.001
            com = (numbers[8], numbers[9], numbers[10])
            self.motions.load = LoadData(mass_kg=numbers[7], com_mm=com) if known else None
        else:
            self.motions.elsewhere("tool", name)
        if base == "wobj0":
            self.motions.base = NONE
        elif (found := self._numbers(*self._text(0, base))) is not None and len(found[0]) >= 14:
            if self._flags(base)[:2] not in (["FALSE", "TRUE"], ["FALSE"]):
                return f"work object {base!r} is moved by a robot or an axis"
            self.motions.base = Frame(_frame(found[0]) @ _frame(found[0][7:]))
        else:
            self.motions.elsewhere("base", base)
        return ""

    def _flags(self, name: str) -> list[str]:
        """What is TRUE and FALSE in the data of a tool or work object."""
        return re.findall(r"\b(?:TRUE|FALSE)\b", self._text(0, name)[1].upper())

    def _text(self, start: int, text: str) -> Text:
        text = text.split("\\")[0].strip()
        if text.startswith("["):
            return start, text
        return self.declared.get(self.key(text, self.routine), NOTHING)

    def declare(self, routine: int, name: str, text: Text) -> None:
        """Data of a routine, or of the module between them."""
        key = routine, name.lower()
        self.declared[key] = text
        if routine % 2 == 0:
            self.shared.setdefault(key[1], key)

    def key(self, name: str, routine: int) -> Key:
        """Of the data that a name means in a routine: its own, or the module's."""
        key = routine, name.lower()
        return key if key in self.declared else self.shared.get(key[1], (0, key[1]))

    def _is_computed(self, text: str) -> bool:
        """Whether the program sets the data of a name."""
        return self.key(text.split("\\")[0].strip(), self.routine) in self.computed

    def _numbers(self, start: int, text: str) -> tuple[list[float], list[tuple[int, int]]] | None:
        words = re.sub(rf"{NUMBER}|\b(?:TRUE|FALSE)\b", "", text, flags=re.I)
        if not text or re.search(r"[A-Z_]", words, re.I):  # not there, or a number is computed
            return None
        found = list(re.finditer(NUMBER, text))
        spans = [(start + match.start(), start + match.end()) for match in found]
        return [float(match[0]) for match in found], spans

    def _target(self, start: int, text: str) -> tuple[list[float], list[tuple[int, int]]] | None:
        found = self._numbers(*self._text(start, text))
        return found if found and len(found[0]) in (12, 17) else None

    def _speed(self, text: str) -> float:
        """mm/s: `v100\\V:=35`, `v100`, `[35,500,5000,1000]` or the name of a speeddata."""
        if match := re.search(r"\\V\s*:=\s*([\d.]+)", text, re.I):
            return float(match[1])
        if found := self._numbers(*self._text(0, text)):
            return found[0][0]
        match = re.fullmatch(r"v(\d+)", text.split("\\")[0], re.I)
        return float(match[1]) if match else np.nan


def _rails(numbers: list[float]) -> tuple[float, ...]:
    return tuple(1e-3 * value for value in numbers if value < NO_AXIS)


def _frame(numbers: list[float]) -> Array:
    """(4, 4) from x y z [mm] and a quaternion."""
    turn = rotations.from_quaternions(np.array([numbers[3:7]]))
    return rotations.pose(1e-3 * np.array([numbers[:3]]), turn)[0]
