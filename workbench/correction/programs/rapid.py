r"""ABB RAPID, written: one module with robtargets (or jointtargets) and one procedure that goes through them.

Conventions of the RAPID reference manual: mm, quaternions w x y z of length 1, degrees for joints,
9E+09 for an external axis that is not there. `\V` and `\T` say a leg's speed [mm/s] or time [s], `\Z`
the corner zone [mm]. Names up to 32 characters. A num is a float of 32 bits: the controller itself
keeps about seven digits (0.1 µm at 1 m). `ConfL\Off`: the arm stays in its posture, whatever the
confdata say; these are computed where the joints are known. `rapid_read.py` reads it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...robot import rotations
from .base import Array, Program
from .format import Format
from .motions import Motions
from .rapid_read import RAPID_FULL_JOINT_SPEED, scan

NO_AXIS = "9E+09"
RAPID_WORDS = """
ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE
ENDPROC ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE
NOSTEPIN NOT NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY RETURN STEP SYSMODULE TASK TEST THEN TO TRAP
TRUE TRYNEXT UNDO VAR VIEWONLY WHILE WITH XOR"""


class Rapid(Format):
    name, title, extension = "rapid", "ABB RAPID", ".mod"
    also = (".modx", ".prg")
    mm_digits = 4
    quaternion_digits = 8
    longest_name = 32
    reserved = frozenset(RAPID_WORDS.split())
    most_rails = 6
    many_lines = 20_000
    fastest = 7.0
    circles = True
    makers = ("abb",)

    def rounding(self) -> tuple[float, float]:
        """Half a digit in four components is 1e-8 of a unit quaternion at most; a rotation twice that."""
        return super().rounding()[0], 4 * 0.5 * 10.0**-self.quaternion_digits

    def warnings(self, program: Program) -> list[str]:
        unknown = program.load is None and not program.at_flange
        own = ["enter the tool's mass in tProgram; the file says 0.001 kg"] if unknown else []
        return super().warnings(program) + own

    def printed(self, X: Array) -> Array:
        turn = np.round(rotations.quaternions(X[:, :3, :3]), self.quaternion_digits)
        place = 1e-3 * np.round(1e3 * X[:, :3, 3], self.mm_digits)
        return rotations.pose(place, rotations.from_quaternions(turn))

    def write(self, program: Program) -> dict[str, str]:
        data, moves = self._joints(program) if program.kind == "joints" else self._path(program)
        head = ["%%%", "  VERSION:1", "  LANGUAGE:ENGLISH", "%%%", f"MODULE {program.name}"]
        procedure = f"{program.name[:28]}_run"
        body = [
            f"  PROC {procedure}()",
            "    ConfJ\\Off;",
            "    ConfL\\Off;",
            *(f"    {move}" for move in moves),
        ]
        data = [*(f"! {note}" for note in program.notes), *self._frames(program), *data]
        lines = [*head, *(f"  {line}" for line in data), *body, "  ENDPROC", "ENDMODULE", ""]
        return {f"{program.name}{self.extension}": "\n".join(lines)}

    def _frames(self, program: Program) -> list[str]:
        """Declarations of the tool with its load, and of the base."""
        found = []
        if self._tool(program) != "tool0":
            mass, centre = "0.001", "0,0,0.001"
            if program.load is not None:
                mass = f"{program.load.mass_kg:.3f}"
                centre = ",".join(f"{value:z.3f}" for value in program.load.com_mm)
            else:
                found.append(
                    "! Enter the tool's mass and centre of mass before running: 0.001 kg stands for unknown."
                )
            load = f"[{mass},[{centre}],[1,0,0,0],0,0,0]"
            found.append(f"LOCAL PERS tooldata tProgram:=[TRUE,[{self._frame(program.tool)}],{load}];")
        if not program.in_world:
            frame = f'[FALSE,TRUE,"",[{self._frame(program.base)}],[[0,0,0],[1,0,0,0]]]'
            found.append(f"LOCAL PERS wobjdata wProgram:={frame};")
        return found

    def _frame(self, X: Array) -> str:
        return self._pose(X, rotations.quaternions(X[None, :3, :3])[0])

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
        return "tool0" if program.at_flange and program.load is None else "tProgram"

    def _with(self, program: Program) -> str:
        return f"{self._tool(program)}\\WObj:={'wobj0' if program.in_world else 'wProgram'};"

    def _joints(self, program: Program) -> tuple[list[str], list[str]]:
        free = f"v100\\V:={RAPID_FULL_JOINT_SPEED * program.share:.3f}"
        data, moves, legs = [], [], program.leg_times
        for i, (arm, rails, dwell) in enumerate(
            zip(program.arm, program.rails, program.dwell, strict=True), 1
        ):
            data.append(f"LOCAL CONST jointtarget j{i}:={self._axes(arm, rails)};")
            speed = f"v100\\T:={legs[i - 1]:.6f}" if np.isfinite(legs[i - 1]) else free
            zone = f"z1\\Z:={1e3 * program.blend:.3f}" if program.passing[i - 1] else "fine"
            moves.append(f"MoveAbsJ j{i}\\NoEOffs,{speed},{zone},{self._with(program)}")
            moves += [f"WaitTime {dwell:.3f};"] if dwell > 0 else []
        return data, moves

    def _confdata(self, program: Program, i: int) -> str:
        """Quarter turns of joints 1, 4 and 6, and the posture: its axis 1, arm and wrist."""
        if program.arm.shape[1] != 6:
            return "[0,0,0,0]"
        quarters = [f"{np.floor(np.degrees(program.arm[i, j]) / 90):.0f}" for j in (0, 3, 5)]
        flags = (True, True, True) if program.posture is None else program.posture[i]
        posture = sum(weight for weight, flag in zip((4, 2, 1), flags, strict=True) if not flag)
        return f"[{','.join(quarters)},{posture}]"

    def _path(self, program: Program) -> tuple[list[str], list[str]]:
        X, legs, rails, arm = program.in_base, self.legs(program), program.rails, program.arm
        via, circular = program.via_in_base, program.circular
        quaternion, over = rotations.quaternions(X[:, :3, :3]), np.zeros((program.count, 4))
        over[circular] = rotations.quaternions(via[circular, :3, :3]) if circular.any() else 0.0
        by_joints = arm.shape[1] == 6
        start = f"v100\\V:={RAPID_FULL_JOINT_SPEED * program.share:.3f},fine,{self._with(program)}"
        data, moves = [], [f"MoveAbsJ {self._axes(arm[0], rails[0])}\\NoEOffs,{start}"] if by_joints else []
        for i in range(program.count):
            rest = f"{self._confdata(program, i)},{self._external(rails[i])}]"
            data.append(f"LOCAL CONST robtarget p{i + 1}:=[{self._pose(X[i], quaternion[i])},{rest};")
            if circular[i]:
                data.append(f"LOCAL CONST robtarget v{i + 1}:=[{self._pose(via[i], over[i])},{rest};")
            speed = f"v100\\V:={1e3 * legs.speed[i]:.6f}" if np.isfinite(legs.speed[i]) else "v100"
            speed = f"v100\\T:={legs.duration[i]:.6f}" if legs.turning[i] else speed
            zone = f"z1\\Z:={1e3 * legs.blend[i]:.3f}" if legs.blend[i] > 0 else "fine"
            move = f"MoveC v{i + 1},p{i + 1}" if circular[i] else f"MoveL p{i + 1}"
            moves.append(
                f"{move},{speed},{zone},{self._with(program)}"
                if i or by_joints
                else f"MoveJ p{i + 1},{start}"
            )
            moves += [f"WaitTime {legs.pause[i]:.3f};"] if legs.pause[i] > 0 else []
        return data, moves

    def decimals(self) -> tuple[int, int]:
        return self.mm_digits, self.quaternion_digits

    def numbers(self, X: Array, like: Array) -> Array:
        quaternion = rotations.quaternions(X[None, :3, :3])[0]
        return np.concatenate([1e3 * X[:3, 3], quaternion * (1.0 if quaternion @ like[3:] >= 0 else -1.0)])

    def scan(self, files: Mapping[str, str]) -> Motions:
        return scan(files)
