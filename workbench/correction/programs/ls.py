"""Fanuc LS, written: a teach pendant program as text (ASCII upload or the offline translator makes a .tp).

Conventions of FANUC: mm and degrees with three decimals, R = Rz(R) Ry(P) Rx(W). Speeds are whole mm/sec or
the leg's time in msec, whichever is nearer to what is wanted; joint moves in whole percent. UFRAME 0 is the
controller's world. A tool and a base come into UTOOL and UFRAME through a position register (`SCRATCH`).
CONFIG of every pose: wrist N or F (joint 5 negative or not), elbow U or D, arm T or B (wrist centre in front
of axis 1 or behind), and the turn numbers of joints 4, 5 and 6 (operator's manual). At most 9999 lines and
position numbers up to 32766 (16 bits). `ls_read.py` reads it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...files.faults import Fault
from ...robot import rotations
from .base import Array, Legs, Program
from .format import Format, by_angles
from .ls_read import scan
from .motions import Motions
from .near import near_zyx
from .posture import turn_numbers

BETWEEN = ",\t"
MOST_LINES = 9999
LONGEST_LEG = 32.0  # s, a leg's time in msec; beyond it in tenths of seconds
SHARP = np.radians(10)  # corners that CNT would cut by more than a tolerance
SCRATCH = 100  # position register that carries the tool and the base
OWN_FRAME = 9  # number of UTOOL and UFRAME that a program with a tool or base of its own sets
LONGEST_REMARK = 32


class Ls(Format):
    """`configuration`: said of every pose where the joints are not known."""

    name, title, extension = "ls", "Fanuc LS", ".ls"
    deg_digits = 3
    longest_name = 36
    upper_case = True
    reserved = frozenset(
        {"CON", "PRN", "AUX", "NUL", *(f"{port}{i}" for port in ("COM", "LPT") for i in range(1, 10))}
    )
    fewest_joints = 4  # palletisers
    most_rails = 3
    most_points = 32766
    fastest = 4.0  # newer controllers; older ones end at 2 m/s
    circles = True
    makers = ("fanuc",)

    def __init__(self, configuration: str = "N U T, 0, 0, 0") -> None:
        self.configuration = configuration

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
        own = [
            name for name, none in (("UTOOL", program.at_flange), ("UFRAME", program.in_world)) if not none
        ]
        if own:
            names = " and ".join(f"{name}[{OWN_FRAME}]" for name in own)
            found.append(f"the program sets {names} through PR[{SCRATCH}]")
        if program.at_flange:
            found.append("UTOOL[1] on the controller has to be zero: the poses are the flange's")
        if program.load is not None:
            x, y, z = program.load.com_mm
            what = f"{program.load.mass_kg:.3f} kg at {x:.1f}, {y:.1f}, {z:.1f} mm"
            found.append(f"a payload schedule of the controller has to say {what}: the file cannot")
        if program.kind == "poses" and self.legs(program).blend.any():
            sharp = ""
            if program.tolerance > 0:
                sharp = f"; the tool stops (FINE) at corners of more than {np.degrees(SHARP):.0f} deg"
            found.append(f"CNT100 rounds corners as the speed has it{sharp}")
        if program.kind == "poses" and program.arm.shape[1] != 6:
            found.append(
                f"every pose says CONFIG '{self.configuration}': the arm has to stand so at the start"
            )
        return found

    def printed(self, X: Array) -> Array:
        return by_angles(X, rotations.zyx_angles, rotations.from_zyx, self.mm_digits, self.deg_digits)

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
        frame, tool = _frame_numbers(program)
        moves = [f"  !{note[:LONGEST_REMARK]}" for note in program.notes]
        if not program.in_world:
            moves += self._set(f"UFRAME[{OWN_FRAME}]", program.base)
        if not program.at_flange:
            moves += self._set(f"UTOOL[{OWN_FRAME}]", program.tool)
        moves += [f"  UFRAME_NUM={frame}", f"  UTOOL_NUM={tool}"]
        share = f"{max(1, round(100 * program.share))}%"
        if program.kind == "joints":
            steps, positions = self._joint_moves(program, share)
        else:
            steps, positions = self._path(program, share)
        return moves + steps, positions

    def _set(self, frame: str, X: Array) -> list[str]:
        """A frame of the controller's by way of a position register."""
        angles = np.degrees(rotations.zyx_angles(X[None, :3, :3])[0])[::-1]
        values = [*(f"{1e3 * v:z.3f}" for v in X[:3, 3]), *(f"{v:z.3f}" for v in angles)]
        said = [f"({value})" if value.startswith("-") else value for value in values]
        elements = [f"  PR[{SCRATCH},{k}]={value}" for k, value in enumerate(said, 1)]
        return [f"  PR[{SCRATCH}]=LPOS", *elements, f"  {frame}=PR[{SCRATCH}]"]

    def _joint_moves(self, program: Program, share: str) -> tuple[list[str], list[str]]:
        moves, positions, legs, frames = [], [], program.leg_times, _frame_numbers(program)
        for i, dwell in enumerate(program.dwell):
            positions.append(_joint_position(i + 1, program.arm[i], program.rails[i], frames))
            pace = _time(legs[i]) if np.isfinite(legs[i]) else share
            moves.append(f"J P[{i + 1}] {pace} {'CNT100' if program.passing[i] else 'FINE'}")
            moves += _wait(dwell)
        return moves, positions

    def _path(self, program: Program, share: str) -> tuple[list[str], list[str]]:
        """By joints to the start where they are known, then L and C through all points."""
        X, legs, via, circular = program.in_base, self.legs(program), program.via_in_base, program.circular
        moves, positions, number = [], [], 0
        frames = _frame_numbers(program)
        if program.arm.shape[1] == 6:
            number = 1
            positions.append(_joint_position(1, program.arm[0], program.rails[0], frames))
            moves.append(f"J P[1] {share} FINE")
        for i in range(program.count):
            posture, over = self._config(program, i), ""
            if circular[i]:
                number += 1
                positions.append(_pose_position(number, via[i], program.rails[i], posture, frames))
                over = f"P[{number}]    \n    :  "
            number += 1
            positions.append(_pose_position(number, X[i], program.rails[i], posture, frames))
            sharp = program.tolerance > 0 and legs.corner[i] > SHARP
            ending = "CNT100" if legs.blend[i] > 0 and not sharp else "FINE"
            move = f"{'C' if over else 'L'} {over}P[{number}] {_pace(legs, i)} {ending}"
            moves.append(move if number > 1 else f"J P[1] {share} FINE")
            moves += _wait(legs.pause[i])
        return moves, positions

    def _config(self, program: Program, i: int) -> str:
        """CONFIG of a pose: the posture that its joints have."""
        if program.arm.shape[1] != 6:
            return self.configuration
        letters = self.configuration.split(",")[0]
        if program.posture is not None:
            front, up, positive = program.posture[i]
            letters = f"{'F' if positive else 'N'} {'U' if up else 'D'} {'T' if front else 'B'}"
        return ", ".join([letters, *(f"{turn}" for turn in turn_numbers(program.arm[i, 3:6]))])

    def numbers(self, X: Array, like: Array) -> Array:
        angles = rotations.zyx_angles(X[None, :3, :3])[0]
        angles = near_zyx(angles, np.radians(like[:2:-1]))[::-1]
        return np.concatenate([1e3 * X[:3, 3], np.degrees(angles)])

    def scan(self, files: Mapping[str, str]) -> Motions:
        return scan(files)


def _frame_numbers(program: Program) -> tuple[int, int]:
    """Numbers of UFRAME and UTOOL: the world's and the flange's, or the program's own."""
    return 0 if program.in_world else OWN_FRAME, 1 if program.at_flange else OWN_FRAME


def _pose_position(number: int, X: Array, rails: Array, posture: str, frames: tuple[int, int]) -> str:
    angles = np.degrees(rotations.zyx_angles(X[None, :3, :3])[0])[::-1]
    place = [f"{n} = {1e3 * v:z9.3f}  mm" for n, v in zip("XYZ", X[:3, 3], strict=True)]
    turn = [f"{n} = {v:z9.3f} deg" for n, v in zip("WPR", angles, strict=True)]
    head = f"\tUF : {frames[0]}, UT : {frames[1]},\t\tCONFIG : '{posture}',"
    return _position(number, [head, f"\t{BETWEEN.join(place)},"], turn, rails)


def _joint_position(number: int, arm: Array, rails: Array, frames: tuple[int, int]) -> str:
    values = [f"J{i}= {value:z9.3f} deg" for i, value in enumerate(np.degrees(arm), 1)]
    head = f"\tUF : {frames[0]}, UT : {frames[1]},\t"
    return _position(number, [head, f"\t{BETWEEN.join(values[:3])},"], values[3:], rails)


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
    return _time(duration)


def _time(duration: float) -> str:
    """A leg's time in whole msec, or tenths of seconds where it is long."""
    return f"{max(1, round(1e3 * duration))}msec" if duration <= LONGEST_LEG else f"{duration:.1f}sec"


def _wait(seconds: float) -> list[str]:
    """A pause in hundredths of seconds; none where it is shorter than half of one."""
    return [f"  WAIT {seconds:6.2f}(sec)"] if seconds >= 0.005 else []
