"""The targets of an existing program in the URDF's joints and frames. `program_postures.py` follows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ..files.faults import Fault, InputError
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.schema import LoadData
from .programs.motions import Frame, Move, Spot
from .programs.posture import Posture
from .programs.shown import stated_convention, turned_load

SAME = 1e-6  # m and rad, by which a frame that is given is that of the program
UNNAMED = ""  # the key of a frame that is given for whichever the program has
SECOND = 1.0  # a leg that does not say how long it takes


Given: TypeAlias = Array | Mapping[str, Array] | None  # (4, 4) of the only frame, or by the program's names


class Frames:
    """From the program's numbers to the URDF's joints and flange, and back. tool, base: those that stand on
    the controller."""

    def __init__(self, robot: Robot, as_urdf: bool, tool: Given = None, base: Given = None) -> None:
        self.robot = robot
        self.tools, self.bases = _by_name(tool), _by_name(base)
        self.convention = None if as_urdf else stated_convention(robot)

    def check(self, moves: Sequence[Move]) -> list[str]:
        """Six turning joints, rails that stand at zero, and all frames known; remarks on frames that are
        taken to be none."""
        faults, remarks = [], list[str]()
        if len(self.robot.joints) != 6 or any(self.robot.sliding):
            what = "has not six turning joints: its programs are not corrected in place"
            faults.append(Fault(self.robot.name, what, "export the path anew"))
        away = next((move for move in moves if np.any(move.rails)), None)
        if away is not None:
            faults.append(
                Fault(away.place, "has external axes that do not stand at 0", "export the path anew")
            )
        for name, given in (("tool", self.tools), ("base", self.bases)):
            frames = [getattr(move, name) for move in moves if move.kind == "pose"]
            faults += _doubts(name, given, frames)
            if UNNAMED not in given and any(frame.X is None and not frame.name for frame in frames):
                remarks.append(
                    f"the program sets no {name}: taken as none (--{name} where the controller has one)"
                )
        if faults:
            raise InputError(faults)
        return remarks

    def joints(self, arm: Sequence[float]) -> Array:
        """(6,) the URDF's joints."""
        q = np.array([arm])
        return np.asarray((self.convention.joints(q) if self.convention else q)[0])

    def shown(self, q: Array) -> Array:
        """(6,) the controller's joints."""
        return np.asarray((self.convention.shown(q[None]) if self.convention else q[None])[0])

    def flange(self, move: Move, X: Array) -> Array:
        """(4, 4) the URDF's flange in its base, of a target in the move's base."""
        return self._base(move) @ X @ np.linalg.inv(self.tool_of(move))

    def in_base(self, move: Move, X: Array) -> Array:
        """(4, 4) the target in the move's base, of its tool in the URDF's."""
        return np.asarray(np.linalg.inv(self._base(move)) @ X)

    def tool_of(self, move: Move) -> Array:
        """(4, 4) the move's tool in the URDF's flange."""
        tool = _found(move.tool, self.tools)
        return tool if self.convention is None else self.convention.from_flange(tool)

    def load(self, load: LoadData) -> LoadData:
        """What the arm carries, from the controller's flange to the URDF's."""
        return load if self.convention is None else turned_load(load, self.convention.flange)

    def _base(self, move: Move) -> Array:
        base = _found(move.base, self.bases)
        return base if self.convention is None else self.convention.from_world(base)


def _by_name(given: Given) -> dict[str, Array]:
    """The frames by the names that the program has for them, in `_key`'s form."""
    if given is None:
        return {}
    named = given.items() if isinstance(given, Mapping) else [(UNNAMED, given)]
    return {_key(name): X for name, X in named}


def _key(name: str) -> str:
    """A name as controllers compare it: without regard to capitals and spaces."""
    return "".join(name.split()).upper()


def _found(frame: Frame, given: Mapping[str, Array]) -> Array:
    """(4, 4) a frame: the file's own, or the one that is given for it."""
    if frame.X is not None:
        return frame.X
    return given.get(_key(frame.name), given.get(UNNAMED, frame.matrix))


def _doubts(name: str, given: Mapping[str, Array], frames: Sequence[Frame]) -> list[Fault]:
    """What stands against taking those that are given for those that the file does not have."""
    absent = {_key(frame.name): frame for frame in frames if frame.X is None}
    faults = []
    has = ", ".join(frame.name for frame in absent.values() if frame.name) or "none"
    for key in sorted(given.keys() - absent.keys() - {UNNAMED}):
        what = f"no {name} of this name stands on the controller; the program has there: {has}"
        faults.append(Fault(f"--{name} {key}", what, "give those, by their names"))
    left = {key: frame for key, frame in absent.items() if key == UNNAMED or key not in given}
    named = [frame for frame in left.values() if frame.name]
    if UNNAMED not in given:
        what = f"this {name} stands on the controller, not in the file"
        return faults + [Fault(frame.place, what, _mend(name, frame, left)) for frame in named]
    if len(left) > 1:
        several = " and ".join(frame.name or "one that is not named" for frame in left.values())
        what = f"{several} are not in the file, and one --{name} is not all of them"
        return [*faults, Fault(named[-1].place, what, _mend(name, named[-1], left))]
    alone = given[UNNAMED]
    own = [frame for frame in frames if frame.X is not None and not np.allclose(frame.X, alone, atol=SAME)]
    if own and not left:
        what = f"--{name} is not that of the program, which has its numbers"
        return [*faults, Fault(f"--{name}", what, "leave it out, or take the other out of the program")]
    return faults


def _mend(name: str, frame: Frame, left: Mapping[str, Frame]) -> str:
    """How to give a frame that is not in the file; one of several by its name."""
    alone = f"give it with --{name} X,Y,Z,A,B,C"
    return alone if len(left) == 1 else f"give each by its name: --{name} '{frame.name}=X,Y,Z,A,B,C'"


@dataclass(frozen=True, eq=False)
class Target:
    """A target of a move: its end, or the point over which its circle goes. X: (4, 4) in the move's base;
    None: joints. spot: where it stands."""

    move: Move
    X: Array | None
    spot: Spot

    @property
    def posture(self) -> Posture | None:
        """What the file says of the posture there; that of a circle's end does not count on the way."""
        return self.move.posture if self.X is self.move.X else None


def targets_of(moves: Sequence[Move]) -> list[Target]:
    found = []
    for move in moves:
        assert move.spot is not None
        if move.via is not None and move.via_spot is not None:
            found.append(Target(move, move.via, move.via_spot))
        found.append(Target(move, move.X, move.spot))
    return found


def times_of(targets: Sequence[Target]) -> Array:
    """(M,) when the arm is there [s]."""
    legs = []
    for target in targets:
        duration = target.move.duration
        whole = duration if duration > 0 else SECOND
        legs.append(whole / 2 if target.move.via is not None else whole)
    return np.cumsum(legs)
