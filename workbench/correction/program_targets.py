"""The targets of an existing program in the URDF's joints and frames. `program_postures.py` follows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..files.faults import Fault, InputError
from ..robot.description import Robot
from ..robot.kinematics import Array
from .programs.motions import Move, Spot
from .programs.posture import Posture
from .programs.shown import stated_convention

SECOND = 1.0  # a leg that does not say how long it takes


class Frames:
    """From the program's numbers to the URDF's joints and flange, and back."""

    def __init__(self, robot: Robot, as_urdf: bool, tool: Array | None, base: Array | None) -> None:
        self.robot, self.tool, self.base = robot, tool, base
        self.convention = None if as_urdf else stated_convention(robot)

    def check(self, moves: Sequence[Move], unknown: Mapping[str, str]) -> None:
        """Six turning joints, no rails, and all frames known."""
        faults = []
        if len(self.robot.joints) != 6 or any(self.robot.sliding):
            what = "has not six turning joints: its programs are not corrected in place"
            faults.append(Fault(self.robot.name, what, "export the path anew"))
        faults += [
            Fault(move.place, "has external axes", "export the path anew") for move in moves[:1] if move.rails
        ]
        for name, given in (("tool", self.tool), ("base", self.base)):
            if given is None and any(getattr(m, name) is None for m in moves if m.kind == "pose"):
                what = f"this {name} stands on the controller, not in the file"
                faults.append(Fault(unknown[name], what, f"give it with --{name} X,Y,Z,A,B,C"))
        if faults:
            raise InputError(faults)

    def joints(self, arm: Sequence[float]) -> Array:
        """(6,) the URDF's joints."""
        q = np.array([arm])
        return np.asarray((self.convention.joints(q) if self.convention else q)[0])

    def shown(self, q: Array) -> Array:
        """(6,) the controller's joints."""
        return np.asarray((self.convention.shown(q[None]) if self.convention else q[None])[0])

    def flange(self, move: Move, X: Array) -> Array:
        """(4, 4) the URDF's flange in its base, of a target in the move's base."""
        return self._base(move) @ X @ np.linalg.inv(self._tool(move))

    def target(self, move: Move, flange: Array) -> Array:
        """(4, 4) the target in the move's base, of the URDF's flange in its base."""
        return np.asarray(np.linalg.inv(self._base(move)) @ flange @ self._tool(move))

    def _base(self, move: Move) -> Array:
        base = move.base if move.base is not None else self.base
        assert base is not None
        return base if self.convention is None else self.convention.from_world(base)

    def _tool(self, move: Move) -> Array:
        tool = move.tool if move.tool is not None else self.tool
        assert tool is not None
        return tool if self.convention is None else self.convention.from_flange(tool)


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
