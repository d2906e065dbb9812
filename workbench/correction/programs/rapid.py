r"""ABB RAPID: one module with robtargets (or jointtargets) and one procedure that goes through them.

Conventions of the RAPID reference manual: mm, quaternions w x y z of length 1, degrees for joints,
9E+09 for an external axis that is not there. `\V` and `\T` say a leg's speed [mm/s] or time [s], `\Z`
the corner zone [mm]. Names up to 32 characters. A num is a float of 32 bits: the controller itself
keeps about seven digits (0.1 µm at 1 m). `ConfL\Off`: the arm stays in its posture, whatever the
confdata say; these are computed where the joints are known. wobj0 has to be the model's base.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from ...robot import rotations
from .base import Array, Program, legs_of
from .format import Format
from .motions import Motions

RAPID_FULL_JOINT_SPEED = 1000.0  # mm/s at the tool that counts as full speed of a joint move
NO_AXIS = "9E+09"
RAPID_MOVE = re.compile(r"(MoveL|MoveJ|MoveAbsJ|MoveC|MoveLDO|MoveJDO)\s*(.*)", re.I | re.S)
RAPID_DECLARED = re.compile(
    r"(?:robtarget|jointtarget|tooldata|speeddata|zonedata)\s+(\w+)\s*:=\s*(\[.*\])", re.I | re.S
)
RAPID_WORDS = """
ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE
ENDPROC ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE
NOSTEPIN NOT NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY RETURN STEP SYSMODULE TASK TEST THEN TO TRAP
TRUE TRYNEXT UNDO VAR VIEWONLY WHILE WITH XOR"""


class Rapid(Format):
    name, title, extension = "rapid", "ABB RAPID", ".mod"
    mm_digits = 4
    quaternion_digits = 8
    longest_name = 32
    reserved = frozenset(RAPID_WORDS.split())
    most_rails = 6
    many_lines = 20_000
    fastest = 7.0

    def rounding(self) -> tuple[float, float]:
        """Half a digit in four components is 1e-8 of a unit quaternion at most; a rotation twice that."""
        return super().rounding()[0], 4 * 0.5 * 10.0**-self.quaternion_digits

    def warnings(self, program: Program) -> list[str]:
        own = (
            []
            if self._tool(program) == "tool0"
            else ["enter the tool's mass in tProgram; the file says 0.001 kg"]
        )
        return super().warnings(program) + own

    def write(self, program: Program) -> dict[str, str]:
        data, moves = self._joints(program) if program.kind == "joints" else self._path(program)
        if not program.at_flange:
            frame = self._pose(program.tool, rotations.quaternions(program.tool[None, :3, :3])[0])
            data = [
                "! Enter the tool's mass and centre of mass before running: 0.001 kg stands for unknown.",
                f"LOCAL PERS tooldata tProgram:=[TRUE,[{frame}],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];",
                *data,
            ]
        head = ["%%%", "  VERSION:1", "  LANGUAGE:ENGLISH", "%%%", f"MODULE {program.name}"]
        procedure = f"{program.name[:28]}_run"
        body = [
            f"  PROC {procedure}()",
            "    ConfJ\\Off;",
            "    ConfL\\Off;",
            *(f"    {move}" for move in moves),
        ]
        lines = [*head, *(f"  {line}" for line in data), *body, "  ENDPROC", "ENDMODULE", ""]
        return {f"{program.name}{self.extension}": "\n".join(lines)}

    def _pose(self, X: Array, quaternion: Array) -> str:
        place = ",".join(f"{1e3 * value:z.{self.mm_digits}f}" for value in X[:3, 3])
        return f"[{place}],[{','.join(f'{value:z.{self.quaternion_digits}f}' for value in quaternion)}]"

    def _external(self, rails: Array) -> str:
        values = [f"{1e3 * value:z.{self.mm_digits}f}" for value in rails]
        return "[" + ",".join([*values, *[NO_AXIS] * 6][:6]) + "]"

    def _axes(self, arm: Array, rails: Array) -> str:
        joints = ",".join(f"{np.degrees(value):z.{self.deg_digits}f}" for value in arm)
        return f"[[{joints}],{self._external(rails)}]"

    def _tool(self, program: Program) -> str:
        return "tool0" if program.at_flange else "tProgram"

    def _joints(self, program: Program) -> tuple[list[str], list[str]]:
        speed = (
            f"v100\\V:={RAPID_FULL_JOINT_SPEED * program.share:.1f},fine,{self._tool(program)}\\WObj:=wobj0;"
        )
        data, moves = [], []
        for i, (arm, rails, dwell) in enumerate(
            zip(program.arm, program.rails, program.dwell, strict=True), 1
        ):
            data.append(f"LOCAL CONST jointtarget j{i}:={self._axes(arm, rails)};")
            moves.append(f"MoveAbsJ j{i}\\NoEOffs,{speed}")
            moves += [f"WaitTime {dwell:.3f};"] if dwell > 0 else []
        return data, moves

    def _path(self, program: Program) -> tuple[list[str], list[str]]:
        X, legs, rails, arm = program.X, legs_of(program), program.rails, program.arm
        assert X is not None
        quaternion, tool = rotations.quaternions(X[:, :3, :3]), f"{self._tool(program)}\\WObj:=wobj0;"
        by_joints = arm.shape[1] == 6
        start = f"v100\\V:={RAPID_FULL_JOINT_SPEED * program.share:.1f},fine,{tool}"
        data, moves = [], [f"MoveAbsJ {self._axes(arm[0], rails[0])}\\NoEOffs,{start}"] if by_joints else []
        for i in range(program.count):
            quarters = [
                f"{np.floor(np.degrees(arm[i, j]) / 90):.0f}" if by_joints else "0" for j in (0, 3, 5)
            ]
            where = f"[{self._pose(X[i], quaternion[i])},[{','.join(quarters)},0],{self._external(rails[i])}]"
            data.append(f"LOCAL CONST robtarget p{i + 1}:={where};")
            speed = f"v100\\V:={1e3 * legs.speed[i]:.4f}" if np.isfinite(legs.speed[i]) else "v100"
            speed = f"v100\\T:={legs.duration[i]:.4f}" if legs.turning[i] else speed
            zone = f"z1\\Z:={1e3 * legs.blend[i]:.3f}" if legs.blend[i] > 0 else "fine"
            moves.append(
                f"MoveL p{i + 1},{speed},{zone},{tool}" if i or by_joints else f"MoveJ p{i + 1},{start}"
            )
            moves += [f"WaitTime {legs.pause[i]:.3f};"] if legs.pause[i] > 0 else []
        return data, moves

    def read(self, files: Mapping[str, str]) -> Program:
        place, text = next(iter(files.items()))
        reader, start = _Reader(Motions(place)), 1
        code = "\n".join(line.split("!")[0] for line in text.splitlines())
        if match := re.search(r"^\s*MODULE\s+(\w+)", code, re.I | re.M):
            reader.motions.name = match[1]
        for statement in code.split(";"):
            line = start + statement[: len(statement) - len(statement.lstrip())].count("\n")
            start += statement.count("\n")
            if match := RAPID_DECLARED.search(statement):
                reader.declared[match[1].lower()] = match[2]
            elif match := re.search(r"WaitTime(?:\s*\\InPos\s*,)?\s*([\d.]+)", statement, re.I):
                reader.motions.wait(float(match[1]))
            elif match := RAPID_MOVE.search(statement):
                reader.move(line + statement[: match.start()].lstrip().count("\n"), match[1], match[2])
        return reader.motions.program()


class _Reader:
    """Reads one statement at a time, with the targets and tools declared so far."""

    def __init__(self, motions: Motions) -> None:
        self.motions = motions
        self.declared: dict[str, str] = {}

    def move(self, line: int, kind: str, text: str) -> None:
        """Target, speed, zone and tool are separated by the commas outside of brackets."""
        parts = [part.strip() for part in re.split(r",(?![^\[]*\])", _flat(text))]
        if kind.lower() not in ("movel", "movej", "moveabsj") or len(parts) < 4:
            self.motions.fault(line, f"{kind} cannot be read", "give the path as MoveL points")
            return
        target = self._numbers(parts[0])
        if target is None:
            self.motions.fault(line, f"no target {parts[0]!r} declared", "declare it in this module")
        elif kind.lower() == "moveabsj":
            arm, rails = target[:6], [value for value in target[6:] if value < 8e9]
            share = self._speed(parts[1]) / RAPID_FULL_JOINT_SPEED
            self.motions.joints(tuple(np.radians(arm)), tuple(1e-3 * np.array(rails)), share)
        else:
            self._pose(line, kind, target, parts)

    def _pose(self, line: int, kind: str, target: list[float], parts: list[str]) -> None:
        if len(target) != 17 or not 0.99 < np.linalg.norm(target[3:7]) < 1.01:
            self.motions.fault(line, "no whole robtarget with a quaternion of length 1")
            return
        if (match := re.search(r"\\WObj\s*:=\s*(\w+)", parts[3], re.I)) and match[1].lower() != "wobj0":
            self.motions.fault(
                line, f"work object {match[1]!r} is not the robot's base", "export the path in wobj0"
            )
        tool = self._numbers(re.split(r"\\", parts[3])[0].strip())
        if tool is not None:
            self.motions.tool = _frame(tool)
        rails = tuple(1e-3 * value for value in target[11:] if value < 8e9)
        duration = re.search(r"\\T\s*:=\s*([\d.]+)", parts[1])
        zone = re.search(r"\\Z\s*:=\s*([\d.]+)", parts[2]) or re.fullmatch(r"z(\d+)", parts[2], re.I)
        self.motions.pose(
            _frame([0.0, *target]),
            rails,
            1e-3 * self._speed(parts[1]) if kind.lower() == "movel" else np.nan,
            duration=float(duration[1]) if duration else np.nan,
            blend=1e-3 * float(zone[1]) if zone else 0.0,
        )

    def _numbers(self, text: str) -> list[float] | None:
        text = text.split("\\")[0].strip()
        text = text if text.startswith("[") else self.declared.get(text.lower(), "")
        words = re.sub(r"[\[\]\s]", "", text.replace("TRUE", "1").replace("FALSE", "0")).split(",")
        try:
            return [float(word) for word in words]
        except ValueError:
            return None

    def _speed(self, text: str) -> float:
        """mm/s: `v100\\V:=35`, `v100`, `[35,500,5000,1000]` or the name of a speeddata."""
        if match := re.search(r"\\V\s*:=\s*([\d.]+)", text, re.I):
            return float(match[1])
        numbers = self._numbers(text)
        if numbers:
            return numbers[0]
        match = re.fullmatch(r"v(\d+)", text, re.I)
        return float(match[1]) if match else np.nan


def _flat(text: str) -> str:
    """The text with nested brackets made one level, so that commas inside of them are told apart."""
    depth, out = 0, []
    for letter in text:
        depth += (letter == "[") - (letter == "]")
        nested = (letter == "[" and depth > 1) or (letter == "]" and depth > 0)
        out.append("" if nested else letter)
    return "".join(out)


def _frame(numbers: list[float]) -> Array:
    """(4, 4) from robhold, x y z [mm], quaternion: the beginning of a tooldata."""
    turn = rotations.from_quaternions(np.array([numbers[4:8]]))
    return rotations.pose(1e-3 * np.array([numbers[1:4]]), turn)[0]
