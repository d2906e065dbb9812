"""KUKA KRL, written: one .src with the positions inline. `krl_read.py` reads it.

Conventions of the KUKA System Software: mm and degrees, R = Rz(A) Ry(B) Rx(C), `$VEL.CP` in m/s,
`$VEL.ORI1` in deg/s, `$VEL_AXIS` in whole percent, external axes E1.. in mm. Names up to 24 characters, the
file's name is the program's name. S and T are left out: they matter for PTP only, and the first point is
reached by its joints where the program knows them. A path of joints with times is a PTP_SPLINE, whose
TIME_BLOCK says the share of the block's time that each leg takes.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...files.faults import Fault
from ...robot import rotations
from .base import Array, Program
from .format import Format, by_angles
from .krl_read import scan
from .motions import Motions
from .near import near_zyx

MOST_BYTES = 8_000_000  # the controller's program memory as users report it (KSS 8.3)
SURELY_FITS = 20_000  # points, whatever is said of each
SLOWEST = 1e-3  # m/s, least value of the controller's own forms
SPEED_DIGITS = 8  # of m/s and of deg/s
USUAL_TURN = 200.0  # deg/s
PART_DIGITS = 9  # of a leg's percentage of its block's time
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
    circles = True
    makers = ("kuka",)

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

    def printed(self, X: Array) -> Array:
        return by_angles(X, rotations.zyx_angles, rotations.from_zyx, self.mm_digits, self.deg_digits)

    def warnings(self, program: Program) -> list[str]:
        found = super().warnings(program)
        speed = self.legs(program).speed
        if program.kind == "poses" and (slow := np.flatnonzero(speed < SLOWEST)).size:
            what = f"goes at {1e3 * speed[slow[0]]:.2g} mm/s; the controller's own forms end at 1 mm/s"
            found.append(f"point {slow[0] + 1} {what}")
        return found

    def write(self, program: Program) -> dict[str, str]:
        body = self._joints(program) if program.kind == "joints" else self._path(program)
        head = [
            *("&ACCESS RVP", "&REL 1", f"DEF {program.name} ( )", "EXT BAS (BAS_COMMAND :IN,REAL :IN )"),
            *(f"; {note}" for note in program.notes),
            *(";FOLD INI", "BAS (#INITMOV,0 )", ";ENDFOLD (INI)"),
            f"$BASE={'$NULLFRAME' if program.in_world else self._pose(program.base, np.empty(0))}",
            f"$TOOL={'$NULLFRAME' if program.at_flange else self._pose(program.tool, np.empty(0))}",
            *self._load(program),
            *("$IPO_MODE=#BASE", "$ORI_TYPE=#VAR", "$CIRC_TYPE=#BASE", "$ADVANCE=5"),
        ]
        return {f"{program.name}{self.extension}": "\n".join([*head, *body, "END", ""])}

    def _load(self, program: Program) -> list[str]:
        """$LOAD without inertia: the controller takes it as a point."""
        if program.load is None:
            return []
        centre = ",".join(f"{n} {v:z.3f}" for n, v in zip("XYZ", program.load.com_mm, strict=True))
        point = "A 0.0,B 0.0,C 0.0},J {X 0.0,Y 0.0,Z 0.0}"
        return [f"$LOAD={{M {program.load.mass_kg:.3f},CM {{{centre},{point}}}"]

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
        """PTP to every target, or, where the path says when, to the first, and splines through the rest."""
        axes = [self._axes(arm, rails) for arm, rails in zip(program.arm, program.rails, strict=True)]
        waits = [[f"WAIT SEC {dwell:.3f}"] if dwell > 0 else [] for dwell in program.dwell]
        lines, legs = self._share(program), program.leg_times
        if program.time is None or program.count < 2:
            return lines + [line for i, text in enumerate(axes) for line in (f"PTP {text}", *waits[i])]
        lines += [f"PTP {axes[0]}", *waits[0]]
        first = 1
        for last in range(1, program.count):
            if program.passing[last]:
                continue
            whole = legs[first : last + 1].sum()
            lines += ["PTP_SPLINE", "TIME_BLOCK START"]
            for i in range(first, last + 1):
                lines += [f"SPTP {axes[i]}", f"TIME_BLOCK PART={100 * legs[i] / whole:.{PART_DIGITS}f}"]
            lines += [f"TIME_BLOCK END={whole:.6f}", "ENDSPLINE", *waits[last]]
            first = last + 1
        return lines

    def _path(self, program: Program) -> list[str]:
        """PTP to the start (by joints where known), then LIN and CIRC through all points."""
        X, rails, legs = program.in_base, program.rails, self.legs(program)
        via, circular = program.via_in_base, program.circular
        by_joints = program.arm.shape[1] == 6
        lines = self._share(program)
        if by_joints:
            lines.append(f"PTP {self._axes(program.arm[0], rails[0])}")
        lines += [
            f"$VEL.ORI1={USUAL_TURN}",
            f"$VEL.ORI2={USUAL_TURN}",
            f"$APO.CDIS={1e3 * legs.blend.max():.3f}",
        ]
        speed, turn = "", f"{USUAL_TURN:.{SPEED_DIGITS}f}"
        for i in range(program.count):
            wanted = f"{legs.speed[i]:.{SPEED_DIGITS}f}" if np.isfinite(legs.speed[i]) else speed or "0.1"
            if wanted != speed:
                speed = wanted
                lines.append(f"$VEL.CP={speed}")
            rate = np.degrees(legs.turn[i]) if legs.turning[i] else USUAL_TURN
            if (wanted := f"{rate:.{SPEED_DIGITS}f}") != turn:
                turn = wanted
                lines += [f"$VEL.ORI1={turn}", f"$VEL.ORI2={turn}"]
            target = self._pose(X[i], rails[i])
            move = f"LIN {target}" if i or by_joints else f"PTP {target}"
            if circular[i]:
                move = f"CIRC {self._pose(via[i], np.empty(0))},{target}"
            lines.append(move + (" C_DIS" if legs.blend[i] > 0 else ""))
            lines += [f"WAIT SEC {legs.pause[i]:.3f}"] if legs.pause[i] > 0 else []
        return lines

    def numbers(self, X: Array, like: Array) -> Array:
        angles = rotations.zyx_angles(X[None, :3, :3])[0]
        return np.concatenate([1e3 * X[:3, 3], np.degrees(near_zyx(angles, np.radians(like[3:])))])

    def scan(self, files: Mapping[str, str]) -> Motions:
        return scan(files)
