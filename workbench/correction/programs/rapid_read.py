"""ABB RAPID, read: the moves of a module with the targets, tools and work objects that it declares."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from ...files.program_text import NO_AXIS, code_of
from ...robot import rotations
from ...robot.schema import LoadData
from .base import Array
from .motions import NONE, Frame, Motions, Spot
from .posture import of_abb
from .rapid_data import GIVEN, SET, Data
from .rapid_run import Statement, in_order, routines
from .text import arguments

RAPID_FULL_JOINT_SPEED = 1000.0  # mm/s at the tool that counts as full speed of a joint move
LONGEST = 60  # characters of a target in a message
MOVE = re.compile(r"\b(MoveL|MoveJ|MoveAbsJ|MoveC)(?:DO|AO|GO|Sync)?(?:\s+|(?=[\\[]))", re.I)
UNREAD = re.compile(
    r"(?<![\w\\.])(W?Arc[LC]\d?(?:Start|End)?|Trigg(?:L|J|C|LIOs)|Search[LC]|MoveExtJ|"
    r"(?:Spot|Paint|Disp|Cap|Contact)[LJC])(?=[\s\\[])(?!\s*:=)",
    re.I,
)
OPTION = re.compile(r"\\\s*(WObj|TLoad)\s*:=\s*(\w[\w.]*\s*(?:\{[^}]*\})?)", re.I)
SHIFTED = re.compile(r"\b((?:PDisp|EOffs)(?:On|Set|Add))\b", re.I)


def scan(files: Mapping[str, str]) -> Motions:
    """The motions of a module in the order in which they run, with the places of their numbers."""
    file, text = next(iter(files.items()))
    code = code_of(text, "!")
    motions = Motions(file)
    if match := re.search(r"^\s*MODULE\s+(\w+)", code, re.I | re.M):
        motions.name = match[1]
    statements = [(match.start(), match[0]) for match in re.finditer(r"[^;]+", code)]
    bounds = routines(code)
    data = Data(code, statements, bounds)
    for root in in_order(code, statements, bounds):
        reader = _Reader(file, code, motions, data)
        motions.anew()
        for statement in root:
            reader.read(statement)
    return motions


class _Reader:
    """Reads one statement at a time, with what holds there of those before."""

    def __init__(self, file: str, code: str, motions: Motions, data: Data) -> None:
        self.file, self.code, self.motions, self.data = file, code, motions, data
        self.obeyed = {"J": True, "L": True}  # ConfJ and ConfL
        self.shifted = False

    def read(self, statement: Statement) -> None:
        """A motion, or what counts for those to come."""
        start, text = statement.start, statement.text
        self.data.routine, self.data.index = statement.routine, statement.index
        match = MOVE.search(text) or UNREAD.search(text) or SHIFTED.search(text)
        place = match.start(1) if match else len(text) - len(text.lstrip())
        self.motions.line = line = self.code.count("\n", 0, start + place) + 1
        if match and match.re is SHIFTED:
            self.shifted = True
            what = "shifts targets: those of routines that are called elsewhere are taken without"
            self.motions.remark(f"{match[1]} {what}")
        elif re.search(r"\b(?:PDisp|EOffs)Off\b", text, re.I):
            self.shifted = False
        elif match and (match.re is UNREAD or (self.shifted and match[1].lower() != "moveabsj")):
            what = "cannot be read" if match.re is UNREAD else "goes to a shifted target"
            self.motions.fault(line, f"{match[1]} {what}", "export the path anew")
        elif match:
            self.move(match[1].lower(), start + match.end(), text[match.end() :])
        elif match := re.search(r"\bConf(J|L)\s*\\\s*(On|Off)\b", text, re.I):
            self.obeyed[match[1].upper()] = match[2].lower() == "on"
        elif match := re.search(r"\bGripLoad\s+(?!load0\b)", text, re.I):
            self.motions.line = self.code.count("\n", 0, start + match.start()) + 1
            self.motions.remark("GripLoad: this load is not counted, only that of the tool")
        elif match := re.search(r"\bWaitTime(?:\s*\\\s*InPos\s*,)?\s*([\d.]+)", text, re.I):
            self.motions.wait(float(match[1]))
        elif not GIVEN.search(text) and not SET.search(text):
            self._other(start, text)

    def _other(self, start: int, text: str) -> None:
        """Another instruction: told where it takes a target, since it may go there."""
        parts = [(at, part.split("\\")[0].split()) for at, part in arguments(text)]
        for at, words in parts:
            if words and self.data.is_target(words[-1]) and "RETURN" not in text.upper().split():
                self.motions.line = self.code.count("\n", 0, start + text.index(words[-1], at)) + 1
                name = parts[0][1][-2 if len(parts[0][1]) > 1 and words is parts[0][1] else -1]
                what = f"{name} takes the target {words[-1]!r}: whether and how it goes there cannot be read"
                self.motions.fault(self.motions.line, what, "give a MoveL, MoveJ, MoveC or MoveAbsJ")
                return

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
            computed = self.data.is_computed(name)
            if found is None or computed:
                short = name if len(name) <= LONGEST else f"{name[: LONGEST - 3]}..."
                if computed and self.data.is_set(name):
                    what, mend = f"{short!r} is set in the program", "give its numbers"
                elif computed or "(" in name or name.startswith("["):
                    what, mend = f"{short!r} is computed", "give its numbers"
                else:
                    what, mend = f"no target {short!r} declared", "declare it in this module"
                self.motions.fault(line, what, mend)
                return
        speed, zone, tool = (part for _, part in parts[ends : ends + 3])
        moved = self._frames(tool, ",".join([tool, *(part for _, part in parts[ends + 3 :])]))
        if moved:
            self.motions.fault(line, moved, "export the path anew")
            return
        said = re.search(r"\\\s*T\s*:=\s*([\d.]+)", speed, re.I)
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
        corner = re.search(r"\\\s*Z\s*:=\s*([\d.]+)", zone, re.I) or re.fullmatch(r"z(\d+)", zone, re.I)
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
        said = {key.lower(): one.strip().lower() for key, one in OPTION.findall(options)}
        base = said.get("wobj", "wobj0")
        computed = [one for one in (name, base) if self.data.is_computed(one)]
        if computed:
            return f"{computed[0]!r} is set in the program"
        if name == "tool0":
            self.motions.tool, self.motions.load = NONE, None
        elif (found := self.data.numbers(0, name)) is not None and len(found[0]) >= 11:
            numbers = found[0]
            if self.data.flags(name)[:1] == ["FALSE"]:
                return f"tool {name!r} stands still, and the robot holds the work object"
            self.motions.tool = Frame(_frame(numbers))
            self.motions.load = _load(numbers[7:11])
        else:
            self.motions.elsewhere("tool", name)
        if (total := said.get("tload", "load0")) != "load0":
            found = None if self.data.is_computed(total) else self.data.numbers(0, total)
            self.motions.load = _load(found[0][:4]) if found and len(found[0]) >= 4 else None
            if found is None:
                self.motions.remark(f"TLoad {total!r} is not in the file: no load of this motion is counted")
        if base == "wobj0":
            self.motions.base = NONE
        elif (found := self.data.numbers(0, base)) is not None and len(found[0]) >= 14:
            if self.data.flags(base)[:2] not in (["FALSE", "TRUE"], ["FALSE"]):
                return f"work object {base!r} is moved by a robot or an axis"
            self.motions.base = Frame(_frame(found[0]) @ _frame(found[0][7:]))
        else:
            self.motions.elsewhere("base", base)
        return ""

    def _target(self, start: int, text: str) -> tuple[list[float], list[tuple[int, int]]] | None:
        found = self.data.numbers(start, text)
        return found if found and len(found[0]) in (12, 17) else None

    def _speed(self, text: str) -> float:
        """mm/s: `v100\\V:=35`, `v100`, `[35,500,5000,1000]` or the name of a speeddata."""
        if match := re.search(r"\\\s*V\s*:=\s*([\d.]+)", text, re.I):
            return float(match[1])
        if found := self.data.numbers(0, text):
            return found[0][0]
        match = re.fullmatch(r"v(\d+)", text.split("\\")[0], re.I)
        return float(match[1]) if match else np.nan


def _load(numbers: list[float]) -> LoadData | None:
    """Mass [kg] and centre of mass [mm]; 0.001 kg stands for none."""
    mass, x, y, z = numbers
    return LoadData(mass_kg=mass, com_mm=(x, y, z)) if mass > 0.001 else None


def _rails(numbers: list[float]) -> tuple[float, ...]:
    return tuple(1e-3 * value for value in numbers if value < NO_AXIS)


def _frame(numbers: list[float]) -> Array:
    """(4, 4) from x y z [mm] and a quaternion."""
    turn = rotations.from_quaternions(np.array([numbers[3:7]]))
    return rotations.pose(1e-3 * np.array([numbers[:3]]), turn)[0]
