"""The targets of an existing program in the URDF's joints and frames. `program_postures.py` follows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..files.faults import Fault, InputError
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.schema import LoadData
from .programs.motions import Frame, Move, Spot
from .programs.posture import Posture
from .programs.shown import stated_convention, turned_load

SAME = 1e-6  # m and rad, by which a frame that is given is that of the program
SECOND = 1.0  # a leg that does not say how long it takes


class Frames:
    """From the program's numbers to the URDF's joints and flange, and back."""

    def __init__(self, robot: Robot, as_urdf: bool, tool: Array | None, base: Array | None) -> None:
        self.robot, self.tool, self.base = robot, tool, base
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
        for name, given in (("tool", self.tool), ("base", self.base)):
            frames = [getattr(move, name) for move in moves if move.kind == "pose"]
            faults += _doubts(name, given, frames)
            if given is None and any(frame.X is None and not frame.name for frame in frames):
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
        tool = move.tool.matrix if move.tool.X is not None or self.tool is None else self.tool
        return tool if self.convention is None else self.convention.from_flange(tool)

    def load(self, load: LoadData) -> LoadData:
        """What the arm carries, from the controller's flange to the URDF's."""
        return load if self.convention is None else turned_load(load, self.convention.flange)

    def _base(self, move: Move) -> Array:
        base = move.base.matrix if move.base.X is not None or self.base is None else self.base
        return base if self.convention is None else self.convention.from_world(base)


def _doubts(name: str, given: Array | None, frames: Sequence[Frame]) -> list[Fault]:
    """What stands against taking the one that is given for those that the file does not have."""
    open_ = {frame.name: frame for frame in frames if frame.X is None}
    named = [frame for key, frame in open_.items() if key]
    if given is None:
        what = f"this {name} stands on the controller, not in the file"
        mend = f"give it with --{name} X,Y,Z,A,B,C"
        return [Fault(frame.place, what, mend) for frame in named]
    if len(open_) > 1:
        several = " and ".join(key or "one that is not named" for key in open_)
        what = f"{several} are not in the file, and one --{name} is not all of them"
        return [Fault(named[-1].place, what, "write their numbers into the program, or split it")]
    own = [frame for frame in frames if frame.X is not None and not np.allclose(frame.X, given, atol=SAME)]
    if own and not open_:
        what = f"--{name} is not that of the program, which has its numbers"
        return [Fault(f"--{name}", what, "leave it out, or take the other out of the program")]
    return []


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
