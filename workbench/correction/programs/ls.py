"""Fanuc LS: a teach pendant program as text (ASCII upload or the offline translator makes a .tp of it).

Conventions of FANUC: mm and degrees with three decimals, R = Rz(R) Ry(P) Rx(W); joint 3 is shown
against the horizontal, J3 = j3 − j2 (`coupled`). Speeds are whole mm/sec or the leg's time in msec,
whichever is nearer to what is wanted. UFRAME 0 is the controller's world and has to be the model's
base. The file cannot set the tool: UTOOL on the controller has to hold it. At most 9999 lines and
position numbers up to 32766 (16 bits).
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from ...files.faults import Fault
from ...robot import rotations
from .base import Array, Legs, Program, legs_of
from .format import Format
from .motions import Motions

BETWEEN = ",\t"
MOST_LINES = 9999
LONGEST_LEG = 32.0  # s, a leg's time in msec; beyond it in tenths of seconds
LS_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
LS_FIELD = re.compile(rf"\b(X|Y|Z|W|P|R|J\d|E\d)\s*=\s*({LS_NUMBER})")
LS_PACE, LS_ENDING = rf"(?:({LS_NUMBER})\s*(%|[a-z/]+))?", r"(FINE|CNT\s*\d+)?"
LS_MOVE = re.compile(rf"^\s*\d*\s*:\s*([JLCA])\s+(PR?)\[(\d+)[^\]]*\]\s*{LS_PACE}\s*{LS_ENDING}", re.I)
METRES = {"mm/sec": 1e-3, "cm/min": 1e-2 / 60, "inch/min": 0.0254 / 60}
SECONDS = {"sec": 1.0, "msec": 1e-3}


class Ls(Format):
    """`configuration`: the arm's posture, the same in every pose: wrist N/F, elbow U/D, front T/B, turns."""

    name, title, extension = "ls", "Fanuc LS", ".ls"
    deg_digits = 3
    longest_name = 36
    upper_case = True
    reserved = frozenset(
        {"CON", "PRN", "AUX", "NUL", *(f"{port}{i}" for port in ("COM", "LPT") for i in range(1, 10))}
    )
    most_rails = 3
    most_points = 32766
    fastest = 4.0  # newer controllers; older ones end at 2 m/s
    carries_tool = False

    def __init__(
        self, configuration: str = "N U T, 0, 0, 0", coupled: bool = True, frame: int = 0, tool: int = 1
    ) -> None:
        self.configuration, self.coupled, self.frame, self.tool = configuration, coupled, frame, tool

    def check(self, program: Program) -> list[Fault]:
        faults = super().check(program)
        if not faults and (lines := len(self._motions(program)[0])) > MOST_LINES:
            parts = -(-lines // MOST_LINES)
            what = f"takes {lines} lines, {self.title} takes {MOST_LINES}"
            mend = f"split the path into {parts} programs, or thin it"
            faults.append(Fault(f"program {program.name!r}", what, mend))
        return faults

    def warnings(self, program: Program) -> list[str]:
        found = super().warnings(program)
        if program.kind == "poses" and not program.at_flange:
            place, turn = self._numbers(program.tool)
            found.append(f"UTOOL[{self.tool}] on the controller has to be {', '.join(place + turn)}")
        if program.kind == "poses" and legs_of(program).blend.any():
            found.append("CNT100 rounds the corners as the speed has it, not by `blend`; blend = 0 says FINE")
        if program.kind == "poses":
            found.append(
                f"every pose says CONFIG '{self.configuration}': the arm has to stand so at the start"
            )
        return found

    def write(self, program: Program) -> dict[str, str]:
        moves, positions = self._motions(program)
        head = [
            f"/PROG  {program.name}",
            *("/ATTR", "OWNER\t\t= MNEDITOR;", 'COMMENT\t\t= "";', "PROG_SIZE\t= 0;"),
            *("CREATE\t\t= DATE 00-01-01  TIME 00:00:00;", "MODIFIED\t= DATE 00-01-01  TIME 00:00:00;"),
            *("FILE_NAME\t= ;", "VERSION\t\t= 0;", f"LINE_COUNT\t= {len(moves)};", "MEMORY_SIZE\t= 0;"),
            *("PROTECT\t\t= READ_WRITE;", "TCD:  STACK_SIZE\t= 0,", "      TASK_PRIORITY\t= 50,"),
            *("      TIME_SLICE\t= 0,", "      BUSY_LAMP_OFF\t= 0,", "      ABORT_REQUEST\t= 0,"),
            *(
                "      PAUSE_REQUEST\t= 0;",
                "DEFAULT_GROUP\t= 1,*,*,*,*;",
                "CONTROL_CODE\t= 00000000 00000000;",
            ),
        ]
        body = [f"{i:4d}:{move}    ;" for i, move in enumerate(moves, 1)]
        text = "\n".join([*head, "/MN", *body, "/POS", *positions, "/END", ""])
        return {f"{program.name}{self.extension}": text}

    def _motions(self, program: Program) -> tuple[list[str], list[str]]:
        """Lines of /MN and entries of /POS."""
        moves, positions = [f"  UFRAME_NUM={self.frame}", f"  UTOOL_NUM={self.tool}"], []
        share, legs = f"{max(1, round(100 * program.share))}%", legs_of(program)
        X, start = program.X, program.kind == "poses" and program.arm.shape[1] == 6
        for i in range(program.count if program.kind == "joints" else int(start)):
            positions.append(self._joint_position(i + 1, program.arm[i], program.rails[i]))
            moves.append(f"J P[{i + 1}] {share} FINE")
            moves += [_wait(program.dwell[i])] if program.kind == "joints" and program.dwell[i] > 0 else []
        for i in range(program.count if program.kind == "poses" and X is not None else 0):
            assert X is not None
            number = i + 1 + int(start)
            positions.append(self._pose_position(number, X[i], program.rails[i]))
            ending = "CNT100" if legs.blend[i] > 0 else "FINE"
            moves.append(f"L P[{number}] {_pace(legs, i)} {ending}" if number > 1 else f"J P[1] {share} FINE")
            moves += [_wait(legs.pause[i])] if legs.pause[i] > 0 else []
        return moves, positions

    def _numbers(self, X: Array) -> tuple[list[str], list[str]]:
        angles = np.degrees(rotations.zyx_angles(X[None, :3, :3])[0])[::-1]
        place = [f"{n} = {1e3 * v:z9.3f}  mm" for n, v in zip("XYZ", X[:3, 3], strict=True)]
        return place, [f"{n} = {v:z9.3f} deg" for n, v in zip("WPR", angles, strict=True)]

    def _pose_position(self, number: int, X: Array, rails: Array) -> str:
        place, turn = self._numbers(X)
        head = f"\tUF : {self.frame}, UT : {self.tool},\t\tCONFIG : '{self.configuration}',"
        return _position(number, [head, f"\t{BETWEEN.join(place)},"], turn, rails)

    def _joint_position(self, number: int, arm: Array, rails: Array) -> str:
        shown = np.degrees(arm)
        if self.coupled:  # against joint 2 as written, so that rounding does not add up
            shown[2] -= round(shown[1], self.deg_digits)
        values = [f"J{i}= {value:z9.3f} deg" for i, value in enumerate(shown, 1)]
        head = f"\tUF : {self.frame}, UT : {self.tool},\t"
        return _position(number, [head, f"\t{BETWEEN.join(values[:3])},"], values[3:], rails)

    def read(self, files: Mapping[str, str]) -> Program:
        place, text = next(iter(files.items()))
        motions = Motions(place)
        if match := re.search(r"^/PROG\s+(\w+)", text, re.M):
            motions.name = match[1]
        instructions, _, rest = text.partition("/POS")
        blocks = re.findall(r"P\[(\d+)[^\]]*\]\s*\{(.*?)\}\s*;", rest, re.S)
        positions = {number: block.split("GP2")[0] for number, block in blocks}
        for number, line in enumerate(instructions.splitlines(), 1):
            if match := re.match(rf"^\s*\d*\s*:\s*WAIT\s+({LS_NUMBER})\s*\(?sec", line, re.I):
                motions.wait(float(match[1]))
            elif match := LS_MOVE.match(line):
                self._read_move(motions, number, match, positions)
        return motions.program()

    def _read_move(
        self, motions: Motions, line: int, match: re.Match[str], positions: Mapping[str, str]
    ) -> None:
        kind, register, index, pace, unit, ending = match.groups()
        block = positions.get(index)
        if kind.upper() in "CA" or register.upper() == "PR" or block is None:
            what = (
                f"{kind} {register}[{index}]"
                + (" has no position" if block is None else "")
                + " cannot be read"
            )
            motions.fault(line, what, "give the path as L P[..] with positions in the file")
            return
        fields = {name: float(value) for name, value in LS_FIELD.findall(block)}
        rails = tuple(1e-3 * fields[f"E{i}"] for i in (1, 2, 3) if f"E{i}" in fields)
        value, unit = float(pace) if pace else np.nan, (unit or "").lower()
        if "J1" in fields:
            arm = np.radians([fields.get(f"J{i}", 0.0) for i in range(1, 7)])
            arm[2] += arm[1] if self.coupled else 0.0
            motions.joints(tuple(arm), rails, value / 100 if unit == "%" else np.nan)
        elif {"X", "Y", "Z", "W", "P", "R"} <= fields.keys():
            self._read_pose(motions, line, fields, block, rails, value, unit, (ending or "FINE").upper())
        else:
            motions.fault(line, f"P[{index}] is no whole position (X Y Z W P R or J1..J6)")

    def _read_pose(
        self, motions: Motions, line: int, fields: Mapping[str, float], block: str,
        rails: tuple[float, ...], value: float, unit: str, ending: str,
    ) -> None:  # fmt: skip
        if (match := re.search(r"UF\s*:\s*(\d+)", block)) and int(match[1]) != self.frame:
            motions.fault(
                line, f"UFRAME {match[1]} is not frame {self.frame}", "export the path in the robot's base"
            )
        turn = rotations.from_zyx(np.radians([[fields[name] for name in "RPW"]]))
        X = rotations.pose(1e-3 * np.array([[fields[name] for name in "XYZ"]]), turn)[0]
        motions.pose(
            X,
            rails,
            speed=value * METRES.get(unit, np.nan),
            turn=np.radians(value) if unit == "deg/sec" else np.nan,
            duration=value * SECONDS.get(unit, np.nan),
            blend=1e-3 if ending.startswith("CNT") and int(ending[3:]) > 0 else 0.0,
        )


def _position(number: int, head: list[str], last: list[str], rails: Array) -> str:
    external = [f"E{i}= {1e3 * value:z9.3f}  mm" for i, value in enumerate(rails, 1)]
    tail = [f"\t{BETWEEN.join(last)}" + ("," if external else "")]
    tail += [f"\t{BETWEEN.join(external)}"] if external else []
    return "\n".join([f"P[{number}]{{", "   GP1:", *head, *tail, "};"])


def _pace(legs: Legs, i: int) -> str:
    """The leg's speed in whole mm/sec or its time in whole msec: whichever is nearer to the leg's time."""
    speed, duration = 1e3 * legs.speed[i], legs.duration[i]
    if not duration > 0:
        return f"{max(1, round(speed))}mm/sec" if np.isfinite(speed) else "100mm/sec"
    length, by_time = 1e3 * legs.distance[i], max(1, round(1e3 * duration))
    by_speed = max(1, round(speed)) if np.isfinite(speed) else 1
    if not legs.turning[i] and abs(length / by_speed - duration) <= abs(1e-3 * by_time - duration):
        return f"{by_speed}mm/sec"
    return f"{by_time}msec" if duration <= LONGEST_LEG else f"{duration:.1f}sec"


def _wait(seconds: float) -> str:
    return f"  WAIT {max(seconds, 0.01):6.2f}(sec)"
