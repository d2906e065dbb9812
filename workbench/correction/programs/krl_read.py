"""KUKA KRL, read: a .src, and its .dat where positions are declared there."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from ...robot import rotations
from ...robot.schema import LoadData
from .base import Array
from .format import NUMBER
from .motions import NONE, UNSAID, Frame, Motions, Spot
from .posture import Posture, of_kuka
from .text import as_run

AGGREGATE = r"\{[^{}]*\}|\$?\w+"
FIELD = re.compile(rf"\b([A-Z]\d?)\s+({NUMBER})(?!\s*[-+*/(\w.])", re.I)  # no number where one is computed
MOVE = re.compile(
    rf"(S?PTP|S?LIN|SPL|S?CIRC)(?:\s+|(?=\{{))({AGGREGATE})\s*(?:,\s*({AGGREGATE}))?\s*(.*)$", re.I
)
DECLARED = re.compile(
    r"^\s*(?:DECL\s+)?(?:GLOBAL\s+)?(?:E[36]?POS|POS|FRAME|E6AXIS|AXIS)\s+(\w+)\s*=\s*(\{.*\})", re.I
)
STATED = re.compile(r"\b([ST])\s+(?:'([BH])([0-9A-F]+)'|(\d+))", re.I)  # decimal, binary or hexadecimal
PLACE, TURN = "XYZ", "ABC"
AXES = tuple(f"A{i}" for i in range(1, 7))
WHERE_IT_STANDS = ("$AXIS_ACT", "$POS_ACT")
HOME = ("XHOME", "HOME")
SET = re.compile(r"\s*(\w+)\s*(?:\.\s*\w+|\[[^\]]*\])?\s*=(?!=)")  # a variable, in the program
FRAMES = re.compile(r"\$(TOOL|BASE)\s*=\s*(\{[^{}]*\}|[^,]+)")  # after WITH: for one motion

PROGRAM = re.compile(r"\s*(?:GLOBAL\s+)?DEF(?:FCT\s+\w+)?\s+(\w+)\s*\(", re.I)
CALL = re.compile(r"(\w+)\s*\(.*\)", re.I)

Text = tuple[str, int, str]  # file, where the text begins in it, the text


def scan(files: Mapping[str, str]) -> Motions:
    """The motions of a .src, with the places of their numbers in it or in the .dat."""
    source = next((name for name in files if name.lower().endswith(".src")), next(iter(files)))
    reader = _Reader(Motions(source))
    for name, text in files.items():
        start = 0
        for line in text.splitlines(keepends=True):
            if name == source and (match := SET.match(line)):
                reader.computed.add(match[1].upper())
            if match := DECLARED.match(line):
                reader.declared[match[1].upper()] = (name, start + match.start(2), match[2])
            elif match := re.match(r"\s*DECL\s+FDAT\s+(\w+)\s*=\s*(.*)", line, re.I):
                reader.frames[match[1].upper()] = match[2].upper()
            start += len(line)
    for root in as_run(_programs(source, files[source]), _called):
        reader.motions.tool = reader.motions.base = UNSAID
        reader.motions.anew()
        for number, at in root:
            reader.motions.line = number
            reader.read(number, at)
    return reader.motions


def _programs(source: str, text: str) -> dict[str, list[tuple[int, Text]]]:
    """The lines of each program of a file, with their numbers, by its name; the first's with what comes
    before."""
    programs: dict[str, list[tuple[int, Text]]] = {}
    name, start, own = "", 0, list[tuple[int, Text]]()
    for number, line in enumerate(text.splitlines(keepends=True), 1):
        code = line.split(";")[0]
        match = PROGRAM.match(code)
        if match:
            own = [] if name else own
            name = match[1].upper()
        own.append((number, (source, start + len(code) - len(code.lstrip()), code.strip())))
        programs[name] = own
        start += len(line)
    if name:
        programs.pop("", None)
    return programs


def _called(line: tuple[int, Text]) -> str | None:
    """The program that a line calls."""
    match = CALL.fullmatch(line[1][2])
    return match[1].upper() if match else None


class _Reader:
    """Goes through a .src line by line, with the settings that hold at the line."""

    def __init__(self, motions: Motions) -> None:
        self.motions = motions
        self.declared: dict[str, Text] = {}
        self.computed: set[str] = set()  # variables that the program sets
        self.frames: dict[str, str] = {}
        self.set: dict[str, float] = {}
        self.parts: list[float] = []
        self.held = False  # the robot holds the work, the tool stands still
        self.before: tuple[Frame, Frame, bool] | None = None  # a spline block

    def read(self, number: int, at: Text) -> None:
        text = at[2]
        upper = text.upper()
        if match := re.match(r"(?:GLOBAL\s+)?DEF\s+(\w+)", text, re.I):
            self.motions.name = self.motions.name or match[1]
        elif match := re.match(rf"WAIT\s+SEC\s+({NUMBER})", upper):
            self.motions.wait(float(match[1]))
        elif match := re.match(rf"BAS\s*\(\s*#(?:CP_PARAMS|VEL_CP)\s*,\s*({NUMBER})", upper):
            self.set["$VEL.CP"] = float(match[1])
        elif match := re.match(rf"(\$(?:VEL|APO)[.\w]*(?:\[1\])?)\s*=\s*({NUMBER})", upper):
            self.set[match[1]] = float(match[2])
        elif upper.startswith("TIME_BLOCK"):
            self._time(upper)
        elif match := re.match(r"\$LOAD\b\s*(.*)", upper):
            self._load(match[1])
        elif match := re.match(r"\$(TOOL|BASE)(\.\w+)?\s*=(?!=)\s*(.*)", upper):
            self._frame(match[1].lower(), text if match[2] else match[3])
        elif match := re.match(r"BAS\s*\(\s*#(TOOL|BASE)\s*,\s*([^)]*)", upper):
            self._numbered(match[1], match[2].strip())
        elif match := re.match(r"FDAT_ACT\s*=\s*(\w+|\{.*)", upper):
            self._data("TOOL", match[1])
            self._data("BASE", match[1])
        elif match := re.match(r"\$IPO_MODE\s*=\s*#(\w+)", upper):
            self.held = match[1] == "TCP"
        elif re.match(r"(PTP_)?SPLINE\b", upper):
            self.before = self.motions.tool, self.motions.base, self.held
            self._with(upper)
        elif upper.startswith("ENDSPLINE") and self.before:
            self.motions.tool, self.motions.base, self.held = self.before
            self.before = None
        elif match := MOVE.match(text):
            self._move(number, at, match)
        elif re.match(r"S?(LIN_REL|PTP_REL|CIRC_REL)\b", upper):
            self.motions.fault(number, f"{upper.split()[0]} cannot be read", "give the path as LIN points")

    def _frame(self, name: str, value: str) -> None:
        fields = {key.upper(): float(v) for key, v in FIELD.findall(value)}
        if value.strip() == "$NULLFRAME":
            setattr(self.motions, name, NONE)
        elif re.fullmatch(r"\{[^{}]*\}\s*", value) and set(PLACE + TURN) <= fields.keys():
            setattr(self.motions, name, Frame(_pose(fields)))
        else:
            self.motions.elsewhere(name, value.strip())

    def _numbered(self, name: str, index: str) -> None:
        """Tool or base of the controller, by its number."""
        self._frame(name.lower(), "$NULLFRAME" if index == "0" else f"{name}_DATA[{index}]")

    def _data(self, name: str, text: str) -> None:
        """Tool or base that an FDAT says, inline or by its name."""
        said = text if text.startswith("{") else self.frames.get(text, "")
        match = re.search(rf"{name}_NO\s+(\d+)", said)
        if match:
            self._numbered(name, match[1])
        else:
            self.motions.elsewhere(name.lower(), text)
        if said:
            self.held = "#TCP" in said

    def _with(self, upper: str) -> None:
        """Tool and base after WITH: SPTP P WITH $TOOL = STOOL2(FP), $BASE = SBASE(FP.BASE_NO)."""
        for name, value in FRAMES.findall(upper.partition("WITH")[2]):
            match = re.match(r"S(?:TOOL2?|BASE)\s*\(\s*(\w+)", value)
            if match and match[1].isdigit():
                self._numbered(name, match[1])
            elif match:
                self._data(name, match[1])
            else:
                self._frame(name.lower(), value)

    def _load(self, value: str) -> None:
        numbers = [float(word) for word in re.findall(NUMBER, value)]
        if re.match(r"=\s*\{", value) and len(numbers) >= 4 and numbers[0] >= 0:
            self.motions.load = LoadData(mass_kg=numbers[0], com_mm=(numbers[1], numbers[2], numbers[3]))
        else:
            self.motions.load = None
            self.motions.remark(f"$LOAD {value}: this load stands on the controller, not in the file")

    def _time(self, upper: str) -> None:
        """TIME_BLOCK START, PART=percent of each leg, END=seconds of all."""
        value = re.search(rf"=\s*({NUMBER})", upper)
        if "PART" in upper and value:
            self.parts.append(float(value[1]))
        elif "END" in upper and value:
            parts = self.parts or [100.0]
            for move, part in zip(self.motions.moves[-len(parts) :], parts, strict=False):
                object.__setattr__(move, "duration", float(value[1]) * part / sum(parts))
        else:
            self.parts = []

    def _target(self, at: Text, text: str, offset: int) -> tuple[dict[str, float], Spot | None, bool]:
        """The numbers of a target, the places of those that say where it is, and whether it was found."""
        if not text.startswith("{"):
            if (found := self.declared.get(text.upper())) is None:
                return {}, None, False
            at, text, offset = found, found[2], 0
        file, start, _ = at
        spans, fields = {}, {}
        for match in FIELD.finditer(text):
            key = match[1].upper()
            fields[key] = float(match[2])
            spans[key] = (start + offset + match.start(2), start + offset + match.end(2))
        for keys in (AXES, tuple(PLACE + TURN)):
            if set(keys) <= spans.keys():
                return fields, Spot(file, tuple(spans[key] for key in keys)), True
        return fields, None, True

    def _posture(self, text: str) -> Posture | None:
        """What S and T of a target say."""
        if not text.startswith("{"):
            text = self.declared[text.upper()][2]
        said = {
            match[1].upper(): int(match[4]) if match[4] else int(match[3], 2 if match[2] in "Bb" else 16)
            for match in STATED.finditer(text)
        }
        return of_kuka(said.get("S"), said.get("T"))

    def _move(self, number: int, at: Text, match: re.Match[str]) -> None:
        kind, last = match[1].upper(), 3 if match[3] else 2
        name, rest = match[last], match[4]
        if rest[:1] in tuple(":[.("):
            what = f"{kind} {name}{rest.partition('WITH')[0].strip()}: a computed target cannot be read"
            self.motions.fault(number, what, "give its numbers")
            return
        if name.upper() in WHERE_IT_STANDS + HOME and name.upper() not in self.declared:
            if name.upper() in HOME:
                self.motions.remark(f"{name} stands on the controller: left alone")
            return
        if computed := [one for one in match.group(2, 3) if one and one.upper() in self.computed]:
            self.motions.fault(number, f"{computed[0]} is set in the program", "give its numbers")
            return
        kept = self.motions.tool, self.motions.base, self.held
        self._with(rest.upper())
        if self.held:
            self.motions.fault(number, "the tool stands still, and the robot holds the work (#TCP)")
        else:
            self._known(number, at, match)
        self.motions.tool, self.motions.base, self.held = kept

    def _known(self, number: int, at: Text, match: re.Match[str]) -> None:
        """A motion whose target stands in the files."""
        kind, last = match[1].upper(), 3 if match[3] else 2
        name = match[last]
        if kind.endswith("CIRC") != bool(match[3]):
            what = "cannot be read" if kind.endswith("CIRC") else "has two targets"
            self.motions.fault(number, f"{kind} {what}", "CIRC needs a via point and an end point")
            return
        fields, spot, found = self._target(at, name, match.start(last))
        rails = tuple(fields[f"E{i}"] * 1e-3 for i in range(1, 7) if f"E{i}" in fields)
        share = self.set.get("$VEL_AXIS[1]", np.nan) / 100
        via, via_spot = None, None
        if match[3]:
            over, via_spot, known = self._target(at, match[2], match.start(2))
            via = _pose(over) if via_spot else None
            found, spot = found and known, spot if via_spot else None
        if spot is not None and "A2" in fields:
            self.motions.joints(tuple(np.radians(fields[key]) for key in AXES), rails, share, spot=spot)
        elif spot is not None:
            free = "PTP" in kind
            rounded = re.match(r"C_(?:DIS|PTP|VEL|ORI)", match[4].upper())
            self.motions.pose(
                _pose(fields),
                rails,
                np.nan if free else self.set.get("$VEL.CP", np.nan),
                np.radians(self.set.get("$VEL.ORI1", np.nan)),
                blend=self.set.get("$APO.CDIS", 0.0) * 1e-3 if rounded else 0.0,
                share=share if free else np.nan,
                via=via,
                spot=spot,
                via_spot=via_spot,
                free=free,
                posture=self._posture(name),
            )
        else:
            what = "no whole position (X Y Z A B C or A1..A6)" if found else f"no position {name!r} declared"
            self.motions.fault(number, what, "" if found else "give the .dat as well")


def _pose(fields: Mapping[str, float]) -> Array:
    x, y, z, a, b, c = (fields.get(name, 0.0) for name in PLACE + TURN)
    turn = rotations.from_zyx(np.radians([[a, b, c]]))
    return rotations.pose(np.array([[x, y, z]]) * 1e-3, turn)[0]
