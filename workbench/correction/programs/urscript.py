"""Universal Robots script: one function with a line per point.

Conventions of the URScript manual: metres and radians, poses p[x,y,z,rx,ry,rz] with a rotation vector,
`v` in m/s, `t` the leg's time in s, `r` the corner in m. Poses are in the controller's base, which
stands half a turn about z from the link that many URDFs call the base. A corner may not reach half a leg.
With `stream` the points go to `servoj` at their own times: for paths sampled every few milliseconds.
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

UR_DIGITS = 8
ACCELERATION = 1.2  # m/s², the manual's default
JOINT_ACCELERATION = 1.4  # rad/s², the manual's default
UR_FULL_JOINT_SPEED = np.pi  # rad/s
LONGEST_STEP = 0.2  # s between points that are streamed
UR_MOVE = re.compile(
    r"\b(movel|movej|movep|movec|servoj|servoc)\s*\(\s*(?:get_inverse_kin\s*\(\s*)?(p?)\[([^\]]*)\](.*)"
)
UR_WORDS = """
and break continue def elif else end enter_critical exit_critical False for global halt if in join
kill local mod not or pass return run sec sync thread True while xor movej movel movep movec servoj sleep"""


class UrScript(Format):
    name, title, extension, newline = "urscript", "URScript", ".script", "\n"
    reserved = frozenset(UR_WORDS.split())
    many_lines = 5000

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
            slow = np.flatnonzero(legs_of(program).duration > LONGEST_STEP)
            what = f"comes more than {LONGEST_STEP} s after the one before, too coarse to stream"
            faults += [Fault(f"program {program.name!r} point {i + 1}", what, "sample the path finer")
                       for i in slow[:1]]  # fmt: skip
        return faults

    def write(self, program: Program) -> dict[str, str]:
        body = self._joints(program) if program.kind == "joints" else self._path(program)
        lines = [
            f"def {program.name}():",
            f"  set_tcp({_pose(program.tool)})",
            *(f"  {line}" for line in body),
        ]
        return {f"{program.name}{self.extension}": "\n".join([*lines, "end", ""])}

    def _joint_move(self, program: Program, i: int) -> str:
        speed = f"a={JOINT_ACCELERATION}, v={UR_FULL_JOINT_SPEED * program.share:.4f}"
        return f"movej([{_numbers(program.arm[i])}], {speed})"

    def _joints(self, program: Program) -> list[str]:
        lines = []
        for i, dwell in enumerate(program.dwell):
            lines += [self._joint_move(program, i), *([f"sleep({dwell:.3f})"] if dwell > 0 else [])]
        return lines

    def _path(self, program: Program) -> list[str]:
        X, legs = program.X, legs_of(program)
        assert X is not None
        lines, by_joints = [], program.arm.shape[1] == 6
        if by_joints:
            lines.append(self._joint_move(program, 0))
        for i in range(program.count):
            timed = legs.turning[i] or not np.isfinite(legs.speed[i])
            pace = f"t={legs.duration[i]:.4f}" if timed else f"v={legs.speed[i]:.7f}"
            corner = f", r={legs.blend[i]:.6f}" if legs.blend[i] > 0 else ""
            if i == 0 and not by_joints:
                speed = f"a={JOINT_ACCELERATION}, v={UR_FULL_JOINT_SPEED * program.share:.4f}"
                lines.append(f"movej({_pose(X[i])}, {speed})")
            elif self.stream and i > 0:
                lines.append(f"servoj(get_inverse_kin({_pose(X[i])}), t={max(legs.duration[i], 0.002):.4f})")
            elif i == 0:
                lines.append(f"movel({_pose(X[i])}, a={ACCELERATION}, v=0.1)")
            else:
                lines.append(f"movel({_pose(X[i])}, a={ACCELERATION}, {pace}{corner})")
            lines += [f"sleep({legs.pause[i]:.3f})"] if legs.pause[i] > 0 else []
        return [*lines, "stopj(2.0)"] if self.stream else lines

    def read(self, files: Mapping[str, str]) -> Program:
        place, text = next(iter(files.items()))
        motions = Motions(place)
        for number, full in enumerate(text.splitlines(), 1):
            line = full.split("#")[0]
            if match := re.match(r"\s*def\s+(\w+)", line):
                motions.name = motions.name or match[1]
            elif match := re.search(r"set_tcp\s*\(\s*p\[([^\]]*)\]", line):
                motions.tool = _read_pose([float(word) for word in match[1].split(",")])
            elif match := re.search(rf"\bsleep\s*\(\s*({NUMBER})", line):
                motions.wait(float(match[1]))
            elif match := UR_MOVE.search(line):
                self._read_move(motions, number, match)
            elif re.search(r"\b(move[jlpc]|servo[jc])\s*\(", line):
                motions.fault(
                    number, "a motion without numbers cannot be read", "give points as p[...] or [...]"
                )
        return motions.program()

    def _read_move(self, motions: Motions, line: int, match: re.Match[str]) -> None:
        kind, pose, inside, rest = match.groups()
        try:
            numbers = [float(word) for word in inside.split(",")]
        except ValueError:
            numbers = []
        if kind in ("movec", "servoc") or len(numbers) != 6:
            motions.fault(line, f"{kind} cannot be read", "give the path as movel with six numbers a point")
            return
        said = {name: float(value) for name, value in re.findall(rf"\b([avtr])\s*=\s*({NUMBER})", rest)}
        if not pose:
            motions.joints(tuple(numbers), share=said.get("v", np.nan) / UR_FULL_JOINT_SPEED)
            return
        straight = kind != "movej"
        motions.pose(
            _read_pose(numbers),
            speed=said.get("v", np.nan) if straight else np.nan,
            duration=said["t"] if straight and said.get("t", 0.0) > 0 else np.nan,
            blend=said.get("r", 0.0),
        )


def _numbers(values: Array) -> str:
    return ",".join(f"{value:z.{UR_DIGITS}f}" for value in values)


def _pose(X: Array) -> str:
    return f"p[{_numbers(np.concatenate([X[:3, 3], rotations.vectors(X[None, :3, :3])[0]]))}]"


def _read_pose(numbers: list[float]) -> Array:
    return rotations.pose(np.array([numbers[:3]]), rotations.from_vectors(np.array([numbers[3:]])))[0]
