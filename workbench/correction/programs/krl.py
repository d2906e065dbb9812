"""KUKA KRL: one .src with the positions inline (a .dat is read too, where positions are declared there).

Conventions of the KUKA System Software: mm and degrees, R = Rz(A) Ry(B) Rx(C), `$VEL.CP` in m/s,
`$VEL.ORI1` in deg/s, external axes E1.. in mm. Names up to 24 characters, the file's name is the
program's name. `$BASE = $NULLFRAME`: positions are in $WORLD, which has to be the model's base.
S and T are left out: they matter for PTP only, and the first point is reached by its joints where
the program knows them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from ...files.faults import Fault
from ...robot import rotations
from .base import Array, Program, legs_of
from .format import NUMBER, Format
from .motions import Motions

MOST_BYTES = 8_000_000  # the controller's program memory as users report it (KSS 8.3)
SURELY_FITS = 20_000  # points, whatever is said of each
SLOWEST = 1e-3  # m/s, least value of $VEL.CP
KRL_STEP = 1e-3  # a change of speed below one part in a thousand is not worth a line
KRL_FIELD = re.compile(rf"\b([A-Z]\d?)\s+({NUMBER})")
KRL_MOVE = re.compile(r"^(S?PTP|S?LIN|SPL)\s*(?:\{(.*?)\}|(\$?\w+))\s*(C_\w+)?", re.I)
KRL_DECLARED = re.compile(
    r"^(?:DECL\s+)?(?:GLOBAL\s+)?(?:E[36]?POS|POS|FRAME|E6AXIS|AXIS)\s+(\w+)\s*=\s*\{(.*)\}", re.I
)
KRL_WORDS = """
AND B_AND B_EXOR B_NOT B_OR BOOL BRAKE CASE CHANNEL CHAR CIRC CIRC_REL CONFIRM CONST CONTINUE DECL
DEF DEFAULT DEFDAT DEFFCT DELAY DISTANCE DO ELSE END ENDDAT ENDFCT ENDFOR ENDIF ENDLOOP ENDSPLINE
ENDSWITCH ENDWHILE ENUM EXIT EXOR EXT FALSE FOR FRAME GLOBAL GOTO HALT IF IMPORT INT INTERRUPT IS LIN
LIN_REL LOOP NOT OR POS PRIO PTP PTP_REL PUBLIC REAL REPEAT RESUME RETURN SIGNAL SPL SPLINE STRUC SWITCH
THEN TO TRIGGER TRUE UNTIL WAIT WHEN WHILE"""


class Krl(Format):
    name, title, extension = "krl", "KUKA KRL", ".src"
    longest_name = 24
    reserved = frozenset(KRL_WORDS.split())
    most_rails = 6
    many_lines = 5000
    fastest = 2.0
    named_as_file = True

    def check(self, program: Program) -> list[Fault]:
        faults = super().check(program)
        if not faults and program.count > SURELY_FITS:
            size = sum(len(text) for text in self.write(program).values())
            if size > MOST_BYTES:
                what = f"takes {size / 1e6:.1f} MB, the controller holds {MOST_BYTES / 1e6:.0f} MB"
                parts = -(-size // MOST_BYTES)
                faults.append(
                    Fault(f"program {program.name!r}", what, f"split the path into {parts} programs")
                )
        return faults

    def write(self, program: Program) -> dict[str, str]:
        body = self._joints(program) if program.kind == "joints" else self._path(program)
        tool = "$NULLFRAME" if program.at_flange else self._pose(program.tool, np.empty(0))
        head = [
            *("&ACCESS RVP", "&REL 1", f"DEF {program.name} ( )", "EXT BAS (BAS_COMMAND :IN,REAL :IN )"),
            *(";FOLD INI", "BAS (#INITMOV,0 )", ";ENDFOLD (INI)"),
            *("$BASE=$NULLFRAME", f"$TOOL={tool}", "$IPO_MODE=#BASE", "$ORI_TYPE=#VAR", "$ADVANCE=5"),
        ]
        return {f"{program.name}{self.extension}": "\n".join([*head, *body, "END", ""])}

    def _axes(self, arm: Array, rails: Array) -> str:
        values = [f"A{i} {np.degrees(value):z.{self.deg_digits}f}" for i, value in enumerate(arm, 1)]
        return "{" + ",".join(values + self._external(rails)) + "}"

    def _pose(self, X: Array, rails: Array) -> str:
        place = [f"{n} {1e3 * v:z.{self.mm_digits}f}" for n, v in zip("XYZ", X[:3, 3], strict=True)]
        angles = np.degrees(rotations.zyx_angles(X[None, :3, :3])[0])
        turns = [f"{n} {v:z.{self.deg_digits}f}" for n, v in zip("ABC", angles, strict=True)]
        return "{" + ",".join(place + turns + self._external(rails)) + "}"

    def _external(self, rails: Array) -> list[str]:
        return [f"E{i} {1e3 * value:z.{self.mm_digits}f}" for i, value in enumerate(rails, 1)]

    def _share(self, program: Program) -> list[str]:
        percent = max(1, round(100 * program.share))
        rails = [f"$VEL_EXTAX[{i}]={percent}" for i in range(1, program.rails.shape[1] + 1)]
        return [f"$VEL_AXIS[{i}]={percent}" for i in range(1, 7)] + rails

    def _joints(self, program: Program) -> list[str]:
        lines = self._share(program)
        for arm, rails, dwell in zip(program.arm, program.rails, program.dwell, strict=True):
            lines.append(f"PTP {self._axes(arm, rails)}")
            lines += [f"WAIT SEC {dwell:.3f}"] if dwell > 0 else []
        return lines

    def _path(self, program: Program) -> list[str]:
        """PTP to the start (by joints where known), then LIN through all points."""
        X, rails, legs = program.X, program.rails, legs_of(program)
        assert X is not None
        by_joints = program.arm.shape[1] == 6
        lines = self._share(program)
        if by_joints:
            lines.append(f"PTP {self._axes(program.arm[0], rails[0])}")
        lines += ["$VEL.ORI1=200.0", "$VEL.ORI2=200.0", f"$APO.CDIS={1e3 * legs.blend.max():.3f}"]
        speed, turn = 0.0, 200.0
        for i in range(program.count):
            wanted = max(legs.speed[i], SLOWEST) if np.isfinite(legs.speed[i]) else speed or 0.1
            if abs(wanted - speed) > KRL_STEP * wanted:
                speed = wanted
                lines.append(f"$VEL.CP={speed:.6f}")
            wanted = np.degrees(legs.turn[i]) if legs.turning[i] else 200.0
            if abs(wanted - turn) > KRL_STEP * wanted:
                turn = wanted
                lines += [f"$VEL.ORI1={turn:.5f}", f"$VEL.ORI2={turn:.5f}"]
            move = "LIN" if i or by_joints else "PTP"
            lines.append(f"{move} {self._pose(X[i], rails[i])}" + (" C_DIS" if legs.blend[i] > 0 else ""))
            lines += [f"WAIT SEC {legs.pause[i]:.3f}"] if legs.pause[i] > 0 else []
        return lines

    def read(self, files: Mapping[str, str]) -> Program:
        source = next((name for name in files if name.lower().endswith(".src")), next(iter(files)))
        declared: dict[str, str] = {}
        for text in files.values():
            for line in text.splitlines():
                if match := KRL_DECLARED.match(line.strip()):
                    declared[match[1].upper()] = match[2]
        reader = _Reader(Motions(source), declared)
        for number, line in enumerate(files[source].splitlines(), 1):
            reader.line(number, line.split(";")[0].strip())
        return reader.motions.program()


class _Reader:
    """Goes through a .src line by line, with the settings that hold at the line."""

    def __init__(self, motions: Motions, declared: dict[str, str]) -> None:
        self.motions, self.declared = motions, declared
        self.set: dict[str, float] = {}

    def line(self, number: int, text: str) -> None:
        upper = text.upper()
        if match := re.match(r"(?:GLOBAL\s+)?DEF\s+(\w+)", text, re.I):
            self.motions.name = self.motions.name or match[1]
        elif match := re.match(rf"WAIT\s+SEC\s+({NUMBER})", upper):
            self.motions.wait(float(match[1]))
        elif match := re.match(rf"BAS\s*\(\s*#(?:CP_PARAMS|VEL_CP)\s*,\s*({NUMBER})", upper):
            self.set["$VEL.CP"] = float(match[1])
        elif match := re.match(rf"(\$(?:VEL|APO)[.\w]*(?:\[1\])?)\s*=\s*({NUMBER})", upper):
            self.set[match[1]] = float(match[2])
        elif upper.startswith(("$TOOL", "$BASE")):
            self._frame(number, upper)
        elif match := KRL_MOVE.match(text):
            self._move(number, match)
        elif re.match(r"S?(CIRC|LIN_REL|PTP_REL)\b", upper):
            self.motions.fault(number, f"{upper.split()[0]} cannot be read", "give the path as LIN points")

    def _frame(self, number: int, upper: str) -> None:
        name, _, value = (part.strip() for part in upper.partition("="))
        if value.startswith("{"):
            frame = self._pose(dict(KRL_FIELD.findall(value)))
            if name == "$TOOL":
                self.motions.tool = frame
            elif not np.allclose(frame, np.eye(4), atol=1e-12):
                self.motions.fault(number, "$BASE is not the robot's base", "export the path in $WORLD")

    def _pose(self, fields: Mapping[str, str]) -> Array:
        x, y, z, a, b, c = (float(fields.get(name, 0.0)) for name in "XYZABC")
        turn = rotations.from_zyx(np.radians([[a, b, c]]))
        return rotations.pose(np.array([[x, y, z]]) * 1e-3, turn)[0]

    def _move(self, number: int, match: re.Match[str]) -> None:
        inline, name, rounded = match[2], match[3], match[4]
        if inline is None and name.upper() in ("$AXIS_ACT", "$POS_ACT", "XHOME", "HOME"):
            return
        text = inline if inline is not None else self.declared.get(name.upper())
        fields = dict(KRL_FIELD.findall((text or "").upper()))
        rails = tuple(float(fields[f"E{i}"]) * 1e-3 for i in range(1, 7) if f"E{i}" in fields)
        if "A1" in fields:
            arm = tuple(np.radians(float(fields.get(f"A{i}", 0.0))) for i in range(1, 7))
            self.motions.joints(arm, rails, self.set.get("$VEL_AXIS[1]", np.nan) / 100)
        elif {"X", "Y", "Z", "A", "B", "C"} <= fields.keys():
            straight = "PTP" not in match[1].upper()
            self.motions.pose(
                self._pose(fields),
                rails,
                self.set.get("$VEL.CP", np.nan) if straight else np.nan,
                np.radians(self.set.get("$VEL.ORI1", np.nan)),
                blend=self.set.get("$APO.CDIS", 0.0) * 1e-3 if rounded else 0.0,
            )
        else:
            what = (
                f"no position {name!r} declared"
                if inline is None
                else "no whole position (X Y Z A B C or A1..A6)"
            )
            self.motions.fault(number, what, "give the .dat as well" if inline is None else "")
