"""Universal Robots script, read: moves whose targets stand as numbers, inline or in a variable."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...robot import rotations
from ...robot.schema import LoadData
from .base import Array
from .format import NUMBER
from .motions import NONE, UNSAID, Frame, Motions, Spot
from .text import arguments, as_run

UR_FULL_JOINT_SPEED = np.pi  # rad/s
CALL = re.compile(r"\b(movel|movej|movep|movec|servoj|servoc)\s*\(")
LIST = r"(p?)\[([^\]]*)\]"
BLOCKS = ("if", "while", "for", "thread", "sec")
STRING = re.compile(r'"[^"]*"')
Line = tuple[int, int, str]  # number, where it begins, the text

SET = re.compile(r"^\s*(?:local\s+|global\s+)?(\w+)\s*(?:\[[^\]]*\])?\s*=(?!=)")
DEFINED = re.compile(r"\s*def\s+(\w+)\s*\(([^)]*)")
ASSIGNED = re.compile(rf"^\s*(?:local\s+|global\s+)?(\w+)\s*=\s*{LIST}\s*$")


def scan(files: Mapping[str, str]) -> Motions:
    """The motions of a script, with the places of their numbers."""
    file, text = next(iter(files.items()))
    reader = _Reader(file)
    for root in as_run(_functions(text), lambda line: _called(line[2])):
        reader.motions.tool = UNSAID
        reader.motions.anew()
        for number, start, line in root:
            reader.motions.line = number
            reader.read(number, start, line)
    return reader.motions


def _functions(text: str) -> dict[str, list[Line]]:
    """The lines of every function, with their numbers and where they begin, by its name; "" what stands
    outside of all, where there is any."""
    functions: dict[str, list[Line]] = {"": []}
    inside, start = [""], 0  # "": a block that is no function
    for number, whole in enumerate(text.splitlines(keepends=True), 1):
        line = STRING.sub(lambda found: " " * len(found[0]), whole.split("#")[0].rstrip("\r\n"))
        word = re.match(r"\s*(\w*)", line)
        function = re.match(r"\s*def\s+(\w+)\s*\(", line)
        if function:
            inside.append(function[1])
            functions.setdefault(function[1], [])
        elif word and word[1] in BLOCKS and line.rstrip().endswith(":"):
            inside.append("")
        functions[next((name for name in reversed(inside) if name), "")].append((number, start, line))
        if word and word[1] == "end" and len(inside) > 1:
            inside.pop()
        start += len(whole)
    if not any(line.strip() for _, _, line in functions[""]):
        del functions[""]
    return functions


def _called(line: str) -> str | None:
    """The function that a line calls."""
    match = re.match(r"\s*(?:\w+\s*=\s*)?(\w+)\s*\(", line)
    return match[1] if match else None


@dataclass(frozen=True, eq=False)
class _Target:
    """Six numbers: a pose in a base (None: not known) or joints, and where they stand; near: the joints [rad]
    that it is to be reached near."""

    numbers: tuple[float, ...]
    is_pose: bool
    spot: Spot
    whole: bool
    base: Frame | None = NONE
    near: tuple[float, ...] | None = None

    @classmethod
    def of(cls, file: str, start: int, pose: str, inside: str) -> _Target:
        found = list(re.finditer(NUMBER, inside))
        spot = Spot(file, tuple((start + match.start(), start + match.end()) for match in found))
        numbers = tuple(float(match[0]) for match in found)
        parts = [part.strip() for part in inside.split(",")]
        whole = len(parts) == 6 and all(re.fullmatch(NUMBER, part) for part in parts)  # none is computed
        return cls(numbers, bool(pose), spot, whole)

    def pose(self) -> Array:
        """(4, 4)."""
        place, turn = np.array([self.numbers[:3]]), np.array([self.numbers[3:]])
        return rotations.pose(place, rotations.from_vectors(turn))[0]


class _Reader:
    def __init__(self, file: str) -> None:
        self.file, self.motions = file, Motions(file)
        self.variables: dict[str, _Target] = {}

    def read(self, number: int, start: int, line: str) -> None:
        if match := SET.match(line):  # a value that is computed is not known
            self.variables.pop(match[1], None)
        if match := DEFINED.match(line):
            self.motions.name = self.motions.name or match[1]
            for name in re.findall(r"\w+", match[2]):
                self.variables.pop(name, None)
        elif match := ASSIGNED.match(line):
            self.variables[match[1]] = _Target.of(self.file, start + match.start(3), match[2], match[3])
        elif match := re.search(r"\bset_tcp\s*\((.*)\)", line):
            tool = self._target(start + match.start(1), match[1])
            if tool is not None and tool.whole:
                self.motions.tool = Frame(tool.pose())
            else:
                self.motions.elsewhere("tool", match[1])
        elif match := re.search(r"\bset_(?:target_)?payload\s*\((.*)", line):
            numbers = [float(word) for word in re.findall(NUMBER, match[1])] + [0.0] * 4
            com = (1e3 * numbers[1], 1e3 * numbers[2], 1e3 * numbers[3])
            known = re.match(rf"\s*{NUMBER}\s*[,)]", match[1])
            self.motions.load = LoadData(mass_kg=numbers[0], com_mm=com) if known else None
            if not known:
                self.motions.remark("this payload is computed, and not known")
        elif match := re.search(rf"\bsleep\s*\(\s*({NUMBER})", line):
            self.motions.wait(float(match[1]))
        elif match := CALL.search(line):
            self._move(number, match[1], start + match.end(), line[match.end() :])

    def _target(self, start: int, text: str) -> _Target | None:
        """The target that an argument says, through get_inverse_kin and pose_trans of a variable frame."""
        found = re.match(r"\s*get_inverse_kin\s*\(", text)
        if found:
            target = self._target(start + found.end(), text[found.end() :])
            said = [part for _, part in arguments(text[found.end() :])][1:]
            near = self._target(0, re.sub(r"^qnear\s*=\s*", "", said[0])) if said else None
            if target is not None and near is not None and near.whole and not near.is_pose:
                return replace(target, near=near.numbers)
            return target
        if found := re.match(rf"\s*pose_trans\s*\(\s*(?:{LIST}|(\w+))\s*,", text):
            inline = _Target.of(self.file, 0, found[1] or "", found[2] or "")
            base = self.variables.get(found[3]) if found[3] else inline
            target = self._target(start + found.end(), text[found.end() :])
            known = base is not None and base.is_pose and base.whole
            frame = Frame(base.pose()) if base is not None and known else None
            return None if target is None else replace(target, base=frame)
        if found := re.match(rf"\s*{LIST}", text):
            return _Target.of(self.file, start + found.start(2), found[1], found[2])
        name = re.match(r"\s*(\w+)\s*(?:[,)]|$)", text)
        return self.variables.get(name[1]) if name else None

    def _move(self, line: int, kind: str, start: int, text: str) -> None:
        parts = arguments(text)
        targets = [self._target(start + place, part) for place, part in parts[: 2 if kind == "movec" else 1]]
        if any(target is None for target in targets):
            what = "a motion without numbers cannot be read"
            self.motions.fault(line, what, "give points as p[...] or [...]")
            return
        known = [target for target in targets if target is not None]
        target = known[-1]
        if kind == "servoc" or len(known) != (2 if kind == "movec" else 1) or not all(t.whole for t in known):
            self.motions.fault(line, f"{kind} cannot be read", "give six numbers a point")
            return
        said = {name: float(value) for name, value in re.findall(rf"\b([avtr])\s*=\s*({NUMBER})", text)}
        timed = said["t"] if said.get("t", 0.0) > 0 else np.nan
        share = said.get("v", np.nan) / UR_FULL_JOINT_SPEED
        if not target.is_pose:
            self.motions.joints(target.numbers, share=share, duration=timed, spot=target.spot)
            return
        if target.base is None:
            self.motions.elsewhere("base", text.strip())
        else:
            self.motions.base = target.base
        straight = kind != "movej"
        self.motions.pose(
            target.pose(),
            speed=said.get("v", np.nan) if straight else np.nan,
            duration=timed if straight else np.nan,
            blend=said.get("r", 0.0),
            share=np.nan if straight else share,
            via=known[0].pose() if kind == "movec" else None,
            spot=target.spot,
            via_spot=known[0].spot if kind == "movec" else None,
            free=not straight,
            near=target.near,
        )
