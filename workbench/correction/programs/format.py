"""What every controller format offers, and the rules of names, limits and values that they share."""

from __future__ import annotations

import re
import unicodedata
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np

from ...files.faults import Fault, InputError
from ...files.program_text import NUMBER as NUMBER  # for readers
from ...robot import rotations
from .base import FINEST_BLEND, STANDSTILL, Array, Legs, Program, legs_of
from .motions import Motions

FARTHEST = 100.0  # m: no robot reaches so far; millimetres were given as metres
HALF_MM, HALF_DEG = 0.5e-3, np.radians(0.5)


def by_angles(
    X: Array, angles: Callable[[Array], Array], back: Callable[[Array], Array], mm: int, deg: int
) -> Array:
    """(N, 4, 4) poses of X (N, 4, 4) with places of `mm` decimals and three angles of `deg` decimals."""
    turn = np.radians(np.round(np.degrees(angles(X[:, :3, :3])), deg))
    return rotations.pose(1e-3 * np.round(1e3 * X[:, :3, 3], mm), back(turn))


class Format(ABC):
    """One controller's program format. The class attributes say its rules; `None` = no limit known.

    extension: of what is written; also: others of existing files.
    makers: of the controllers, in small letters, as a robot's TOML may name them.
    circles: it has circular moves. own_joints: its joints and frames are the controller's, not the URDF's.
    samples: it is a table of samples, never thinned. own_folder: a program's files have
    fixed names, and need a folder of their own. arm_joints: turning joints that poses are for and programs of
    joints have at most; fewest_joints: that these have at least.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    extension: ClassVar[str]
    also: ClassVar[tuple[str, ...]] = ()
    newline: ClassVar[str] = "\r\n"
    mm_digits: ClassVar[int] = 3
    deg_digits: ClassVar[int] = 4
    longest_name: ClassVar[int | None] = None
    upper_case: ClassVar[bool] = False
    reserved: ClassVar[frozenset[str]] = frozenset()
    arm_joints: ClassVar[int | None] = 6
    fewest_joints: ClassVar[int] = 6
    most_rails: ClassVar[int | None] = 0
    most_points: ClassVar[int | None] = None
    many_lines: ClassVar[int | None] = None
    fastest: ClassVar[float | None] = None
    carries_tool: ClassVar[bool] = True
    named_as_file: ClassVar[bool] = False
    circles: ClassVar[bool] = False
    makers: ClassVar[tuple[str, ...]] = ()
    own_joints: ClassVar[bool] = True
    samples: ClassVar[bool] = False
    own_folder: ClassVar[bool] = False

    @property
    def extensions(self) -> tuple[str, ...]:
        """Those of its files, the first is that of what is written."""
        return (self.extension, *self.also)

    @abstractmethod
    def write(self, program: Program) -> dict[str, str]:
        """The files of a checked program: name → text. The first is the one that a user names."""

    def read(self, files: Mapping[str, str]) -> Program:
        """The program in these files; `InputError` with every line that cannot be read."""
        return self.scan(files).program()

    def scan(self, files: Mapping[str, str]) -> Motions:
        """The motions in these files with the places of their numbers; `faults` has what cannot be read."""
        raise InputError(Fault(next(iter(files)), f"{self.title} is read as a table only"))

    def numbers(self, X: Array, like: Array) -> Array:
        """(6,) or (7,) numbers of a pose (4, 4) as the format writes place and turn, of all that say the same
        turn those nearest to `like`."""
        raise InputError(Fault(self.title, "programs are not corrected in place", "export the path anew"))

    def decimals(self) -> tuple[int, int]:
        """Decimals of a place and of a turn, as the format writes them."""
        return self.mm_digits, self.deg_digits

    def joint_decimals(self) -> int:
        """Decimals of a turning joint."""
        return self.deg_digits

    def joint_numbers(self, arm: Array) -> Array:
        """(n,) numbers of turning joints [rad] as the format writes them."""
        return np.degrees(arm)

    def printed(self, X: Array) -> Array:
        """(N, 4, 4) poses as they come back from the numbers that the file has of X (N, 4, 4)."""
        return X

    def legs(self, program: Program) -> Legs:
        """The legs of a program of poses between the points as they are printed, so that a speed that is
        read takes the time that the program has."""
        if program.X is None:
            return legs_of(program)
        X, via, bent = self.printed(program.in_base), program.via_in_base.copy(), program.circular
        via[bent] = self.printed(via[bent])
        plain = replace(program, X=X, via=via if bent.any() else None, base=np.eye(4))
        return legs_of(plain)

    def rounding(self) -> tuple[float, float]:
        """Half a last digit: (of each coordinate [m], the largest rotation of all angles together [rad])."""
        return HALF_MM * 10.0**-self.mm_digits, 3 * self.joint_rounding()[1]

    def joint_rounding(self) -> tuple[float, float]:
        """Half a last digit of a sliding joint [m] and of a turning joint [rad]."""
        return HALF_MM * 10.0**-self.mm_digits, HALF_DEG * 10.0**-self.deg_digits

    def check(self, program: Program) -> list[Fault]:
        """Everything that this controller would refuse, each with how to mend it."""
        faults = self._check_name(program) + self._check_values(program)
        if not faults:
            faults = self._check_axes(program) + self._check_limits(program)
        return faults

    def warnings(self, program: Program) -> list[str]:
        """What the controller takes but the user should know."""
        found = []
        if program.kind == "poses" and program.count > 2 and not self.legs(program).blend[1:-1].any():
            found.append(
                f"the tool stops at every point: no legs longer than {2.5e3 * FINEST_BLEND:.3f} mm to round, "
                "or blend = 0"
            )
        if program.kind == "poses" and self.arm_joints not in (None, program.arm.shape[1]):
            found.append(
                "the joints of the start are not given: the arm stays in the posture that it stands in"
            )
        if self.many_lines is not None and program.count > self.many_lines:
            found.append(
                f"{program.count} points; beyond {self.many_lines} {self.title} gets slow: split the path"
            )
        return found

    def legal_name(self, text: str) -> str:
        """A program name after this controller's rules that resembles `text`."""
        plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
        name = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_") or "path"
        name = name if name[0].isalpha() else f"p{name}"
        name = (name.upper() if self.upper_case else name)[: self.longest_name]
        return f"{name[:-1]}1" if self._is_reserved(name) else name

    def _is_reserved(self, name: str) -> bool:
        return name.upper() in {word.upper() for word in self.reserved}

    def _check_name(self, program: Program) -> list[Fault]:
        name, what = program.name, ""
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
            what = "must be letters, digits and _, a letter first"
        elif self.longest_name is not None and len(name) > self.longest_name:
            what = f"has {len(name)} characters, {self.title} takes {self.longest_name}"
        elif self._is_reserved(name):
            what = f"is a word of {self.title} itself"
        elif self.upper_case and name != name.upper():
            what = "must be in capitals"
        return [Fault(f"program name {name!r}", what, f"say {self.legal_name(name)!r}")] if what else []

    def _check_values(self, program: Program) -> list[Fault]:
        """Points without number, poses that are none, time that does not run on."""
        place, faults = f"program {program.name!r}", []
        if program.count == 0:
            return [Fault(place, "has no points", "give at least one")]
        numbers = [value.reshape(program.count, -1) for value in (program.X, program.q, program.time)
                   if value is not None]  # fmt: skip
        bad = np.flatnonzero(~np.isfinite(np.hstack([*numbers, program.dwell[:, None]])).all(axis=1))
        if len(bad):
            return [Fault(f"{place} point {i + 1}", "holds a value that is no number") for i in bad]
        for i in np.flatnonzero(program.dwell < 0):
            faults.append(Fault(f"{place} point {i + 1}", "dwells a negative time"))
        if not 0 < program.share <= 1:
            faults.append(Fault(place, f"share of the joint speed is {program.share}", "between 0 and 1"))
        if not np.isfinite(program.tool).all() or not _is_pose(program.tool[None])[0]:
            faults.append(Fault(f"{place} tool", "is no pose (rotation not orthonormal)"))
        if program.X is not None:
            faults += [Fault(f"{place} point {i + 1}", "is no pose (rotation not orthonormal)")
                       for i in np.flatnonzero(~_is_pose(program.X))]  # fmt: skip
            far = np.flatnonzero(np.abs(program.X[:, :3, 3]).max(axis=1) > FARTHEST)
            faults += [Fault(f"{place} point {i + 1}", f"is more than {FARTHEST:.0f} m away",
                             "positions are in metres") for i in far]  # fmt: skip
        return faults + (_check_leg_times if program.kind == "joints" else _check_time)(program, place)

    def _check_axes(self, program: Program) -> list[Fault]:
        place, rails = f"program {program.name!r}", program.rails.shape[1]
        if program.q is None or self.most_rails is None:
            return []
        if program.sliding != (True,) * rails + (False,) * (len(program.sliding) - rails):
            return [Fault(place, f"a sliding joint inside the arm: {self.title} knows rails only", "use csv")]
        if rails > self.most_rails:
            return [Fault(place, f"{rails} rails, {self.title} takes {self.most_rails}", "use csv")]
        arm = program.arm.shape[1]
        fewest, most = self.fewest_joints, self.arm_joints
        if program.kind == "joints" and most is not None and not fewest <= arm <= most:
            takes = f"{fewest} to {most}" if fewest < most else f"{most}"
            return [Fault(place, f"{arm} turning joints, {self.title} takes {takes}", "use csv")]
        return []

    def _check_limits(self, program: Program) -> list[Fault]:
        place, faults = f"program {program.name!r}", []
        if self.most_points is not None and program.count > self.most_points:
            parts = -(-program.count // self.most_points)
            faults.append(
                Fault(place, f"{program.count} points, {self.title} takes {self.most_points}",
                      f"split the path into {parts} programs, or thin it")
            )  # fmt: skip
        if self.fastest is not None and program.kind == "poses":
            for i in np.flatnonzero(program.speed > self.fastest * (1 + 1e-9))[:1]:
                what = f"goes at {program.speed[i]:.3g} m/s, {self.title} takes {self.fastest:g} m/s"
                faults.append(Fault(f"{place} point {i + 1}", what, "stretch the path's time"))
        return faults


def _is_pose(X: Array) -> np.ndarray:
    R = X[:, :3, :3]
    square = np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)).max(axis=(1, 2)) < 1e-6
    bottom = (X[:, 3] == [0.0, 0.0, 0.0, 1.0]).all(axis=1)
    return np.asarray(square & (np.linalg.det(R) > 0) & bottom)


def _check_leg_times(program: Program, place: str) -> list[Fault]:
    """Of a path of joints, where it has times."""
    short = np.flatnonzero(program.leg_times[1:] <= 0) + 1
    what = "has no time to get there (dwell counted)"
    return [Fault(f"{place} point {i + 1}", what, "order the points by time") for i in short]


def _check_time(program: Program, place: str) -> list[Fault]:
    if program.time is None:
        return [Fault(place, "has no time, so no speed", "give t_s")]
    legs = legs_of(program)
    late = np.flatnonzero(legs.duration[1:] < 0) + 1
    jump = (
        np.flatnonzero((legs.duration[1:] == 0) & (np.maximum(legs.distance, legs.angle) > STANDSTILL)[1:])
        + 1
    )
    return [
        Fault(f"{place} point {i + 1}", "time runs back (dwell counted)", "order the points by time")
        for i in late
    ] + [Fault(f"{place} point {i + 1}", "moves in no time", "give each point its own time") for i in jump]
