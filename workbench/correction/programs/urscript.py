"""Universal Robots script, written: one function with a line per point. `urscript_read.py` reads it.

Conventions of the URScript manual: metres and radians, poses p[x,y,z,rx,ry,rz] with a rotation vector,
`v` in m/s, `t` the leg's time in s, `r` the corner in m. A corner may not reach half a leg.
With `stream` the points go to `servoj` at their own times: for paths sampled every few milliseconds.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...files.faults import Fault
from ...robot import rotations
from .base import Array, Program
from .format import Format
from .motions import Motions
from .near import near_vector
from .urscript_read import UR_FULL_JOINT_SPEED, scan

UR_DIGITS = 8
ACCELERATION = 1.2  # m/s², the manual's default
JOINT_ACCELERATION = 1.4  # rad/s², the manual's default
LONGEST_STEP = 0.2  # s between points that are streamed
SHORTEST_STEP = 0.002  # s, the controller's own
SECOND_DIGITS = 7
BASE = "base_frame"  # variable that holds the base
UR_WORDS = """
and break continue def elif else end enter_critical exit_critical False for global halt if in join
kill local mod not or pass return run sec sync thread True while xor movej movel movep movec servoj sleep"""


class UrScript(Format):
    name, title, extension, newline = "urscript", "URScript", ".script", "\n"
    also = (".urscript",)
    reserved = frozenset(UR_WORDS.split())
    many_lines = 5000
    circles = True
    makers = ("universal robots", "ur")

    def __init__(self, stream: bool = False) -> None:
        self.stream = stream

    def rounding(self) -> tuple[float, float]:
        """A rotation vector moves the rotation by its own change at most: √3 half digits."""
        half = 0.5 * 10.0**-UR_DIGITS
        return half, np.sqrt(3.0) * half

    def joint_rounding(self) -> tuple[float, float]:
        return 0.5 * 10.0**-UR_DIGITS, 0.5 * 10.0**-UR_DIGITS

    def check(self, program: Program) -> list[Fault]:
        faults = super().check(program)
        if not faults and self.stream and program.kind == "poses":
            slow = np.flatnonzero(self.legs(program).duration > LONGEST_STEP)
            what = f"comes more than {LONGEST_STEP} s after the one before, too coarse to stream"
            faults += [Fault(f"program {program.name!r} point {i + 1}", what, "sample the path finer")
                       for i in slow[:1]]  # fmt: skip
        return faults

    def printed(self, X: Array) -> Array:
        turn = np.round(rotations.vectors(X[:, :3, :3]), UR_DIGITS)
        return rotations.pose(np.round(X[:, :3, 3], UR_DIGITS), rotations.from_vectors(turn))

    def write(self, program: Program) -> dict[str, str]:
        body = self._joints(program) if program.kind == "joints" else self._path(program)
        frames = [f"set_tcp({_pose(program.tool)})"]
        if program.load is not None:
            centre = ",".join(f"{1e-3 * value:z.6f}" for value in program.load.com_mm)
            frames.append(f"set_payload({program.load.mass_kg:.3f}, [{centre}])")
        if not program.in_world:
            frames.append(f"{BASE} = {_pose(program.base)}")
        lines = [
            f"def {program.name}():",
            *(f"  # {note}" for note in program.notes),
            *(f"  {line}" for line in [*frames, *body]),
        ]
        return {f"{program.name}{self.extension}": "\n".join([*lines, "end", ""])}

    def _joint_move(self, program: Program, i: int) -> str:
        return f"movej([{_numbers(program.arm[i])}], {_free(program)})"

    def _joints(self, program: Program) -> list[str]:
        """movej to every target, or, where the path says when, servoj at short steps and movej in time."""
        lines = []
        for i, (dwell, leg) in enumerate(zip(program.dwell, program.leg_times, strict=True)):
            move = self._joint_move(program, i)
            if np.isfinite(leg):
                target = f"[{_numbers(program.arm[i])}]"
                move = f"movej({target}, a={JOINT_ACCELERATION}, t={leg:.{SECOND_DIGITS}f})"
                if leg <= LONGEST_STEP:
                    move = f"servoj({target}, t={leg:.{SECOND_DIGITS}f})"
            lines += [move, *([f"sleep({dwell:.3f})"] if dwell > 0 else [])]
        return lines

    def _path(self, program: Program) -> list[str]:
        X, legs, via, circular = program.in_base, self.legs(program), program.via_in_base, program.circular
        lines, by_joints = [], program.arm.shape[1] == 6
        if by_joints:
            lines.append(self._joint_move(program, 0))
        for i in range(program.count):
            target = self._target(program, X[i])
            timed = legs.turning[i] or not np.isfinite(legs.speed[i])
            pace = f"t={legs.duration[i]:.{SECOND_DIGITS}f}" if timed else f"v={legs.speed[i]:.9f}"
            corner = f", r={legs.blend[i]:.6f}" if legs.blend[i] > 0 else ""
            if i == 0 and not by_joints:
                lines.append(f"movej({target}, {_free(program)})")
            elif self.stream and i > 0:
                step = max(legs.duration[i], SHORTEST_STEP)
                lines.append(f"servoj(get_inverse_kin({target}), t={step:.{SECOND_DIGITS}f})")
            elif i == 0:
                lines.append(f"movel({target}, a={ACCELERATION}, v=0.1)")
            elif circular[i]:
                over = self._target(program, via[i])
                lines.append(f"movec({over}, {target}, a={ACCELERATION}, {pace}{corner}, mode=0)")
            else:
                lines.append(f"movel({target}, a={ACCELERATION}, {pace}{corner})")
            lines += [f"sleep({legs.pause[i]:.3f})"] if legs.pause[i] > 0 else []
        return lines

    def _target(self, program: Program, X: Array) -> str:
        return _pose(X) if program.in_world else f"pose_trans({BASE}, {_pose(X)})"

    def numbers(self, X: Array, like: Array) -> Array:
        return np.concatenate([X[:3, 3], near_vector(rotations.vectors(X[None, :3, :3])[0], like[3:])])

    def decimals(self) -> tuple[int, int]:
        return UR_DIGITS, UR_DIGITS

    def joint_decimals(self) -> int:
        return UR_DIGITS

    def joint_numbers(self, arm: Array) -> Array:
        return arm

    def scan(self, files: Mapping[str, str]) -> Motions:
        return scan(files)


def _numbers(values: Array) -> str:
    return ",".join(f"{value:z.{UR_DIGITS}f}" for value in values)


def _pose(X: Array) -> str:
    return f"p[{_numbers(np.concatenate([X[:3, 3], rotations.vectors(X[None, :3, :3])[0]]))}]"


def _free(program: Program) -> str:
    """Pace of a joint move at the program's share."""
    return f"a={JOINT_ACCELERATION}, v={UR_FULL_JOINT_SPEED * program.share:.9f}"
