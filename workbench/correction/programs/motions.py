"""The motions that a reader collects while it goes through a controller's file; becomes a `Program`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...files.faults import Fault, InputError
from ...robot.schema import LoadData
from .base import STANDSTILL, Array, Program, legs_of
from .posture import Posture

Span = tuple[int, int]


@dataclass(frozen=True)
class Spot:
    """Where a target's numbers stand: `spans` of the text of `file`, of place and turn or of joints. absent:
    for each of them, how it is written where the file leaves it out for zero (its span is empty then), or
    nothing where it is there."""

    file: str
    spans: tuple[Span, ...]
    absent: tuple[str, ...] = ()

    def old(self, text: str) -> list[str]:
        """The numbers as they stand in the file's text."""
        return [text[start:end] or "0" for start, end in self.spans]

    def changes(self, numbers: Sequence[str]) -> list[tuple[Span, str]]:
        """What to put in their places."""
        forms = self.absent or ("",) * len(self.spans)
        return [
            (span, form.format(number) if form else number)
            for span, number, form in zip(self.spans, numbers, forms, strict=True)
        ]


@dataclass(frozen=True, eq=False)
class Frame:
    """Tool or base where a motion is. X: (4, 4); None where it stands on the controller, under a name, or
    where nothing is said of it (no name): then it is none, or whatever the controller has set."""

    X: Array | None = None
    name: str = ""
    place: str = ""

    @property
    def matrix(self) -> Array:
        """(4, 4), of one that is not known that of none."""
        return np.eye(4) if self.X is None else self.X


NONE = Frame(np.eye(4))  # the flange, the robot's own base
UNSAID = Frame()


@dataclass(frozen=True, eq=False)
class Move:
    """One motion as the file has it: to a tool pose (4, 4) in `base`, or to joints.

    arm: turning joints [rad]; rails [m]; speed [m/s], turn [rad/s], duration [s] of the leg, NaN where not
    said; share of the joints' full speed; blend: corner [m]; via: of a circle, in `base`, with its own spot.
    free: the joints go there at once, not the tool along a line. posture: what the file says of it there;
    near: joints [rad] that it is to be nearest to. load: what the file says that the arm carries here. anew:
    what comes before in the list says nothing of where the arm comes from.
    """

    kind: Literal["pose", "joints"]
    place: str
    X: Array | None = None
    arm: tuple[float, ...] = ()
    rails: tuple[float, ...] = ()
    speed: float = np.nan
    turn: float = np.nan
    duration: float = np.nan
    share: float = np.nan
    blend: float = 0.0
    via: Array | None = None
    spot: Spot | None = None
    via_spot: Spot | None = None
    line: int = 0
    tool: Frame = UNSAID
    base: Frame = UNSAID
    free: bool = False
    posture: Posture | None = None
    near: tuple[float, ...] | None = None
    load: LoadData | None = None
    anew: bool = False

    @property
    def file(self) -> str:
        """The file in which it stands."""
        return self.place.split(" line ")[0]


class Motions:
    """Motions in the order of the file, with what the file says of the way to each.

    A program with poses is a path: joint moves before its first pose bring the arm there and those
    after it bring the arm away; neither are points of the path. faults: motions that cannot be read;
    remarks: what else a user of the others should know.
    """

    def __init__(self, place: str) -> None:
        self.place = place
        self.name = ""
        self.tool, self.base = UNSAID, UNSAID
        self.load: LoadData | None = None
        self.faults: list[Fault] = []
        self.remarks: list[Fault] = []
        self.moves: list[Move] = []
        self.line: int | str = ""
        self._anew = False
        self._dwell: dict[int, float] = {}

    def pose(
        self,
        X: Array,
        rails: tuple[float, ...] = (),
        speed: float = np.nan,
        turn: float = np.nan,
        duration: float = np.nan,
        blend: float = 0.0,
        *,
        share: float = np.nan,
        via: Array | None = None,
        spot: Spot | None = None,
        via_spot: Spot | None = None,
        free: bool = False,
        posture: Posture | None = None,
        near: tuple[float, ...] | None = None,
    ) -> None:
        """A tool pose (4, 4) in the base; tool speed [m/s], turning speed [rad/s] or time of the leg [s];
        corner [m]; share of full speed where joints move freely; the pose over which a circle goes; whether
        the joints move freely, and in which posture the arm stands there, or near which joints."""
        move = Move(
            "pose", self._where, X, (), rails, speed, turn, duration, share, blend, via, spot, via_spot
        )
        self._add(replace(move, free=free, posture=posture, near=near))

    def joints(
        self,
        arm: tuple[float, ...],
        rails: tuple[float, ...] = (),
        share: float = np.nan,
        duration: float = np.nan,
        *,
        spot: Spot | None = None,
    ) -> None:
        """Joint targets: turning joints [rad], rails [m], share of the full speed or time of the leg [s]."""
        self._add(Move("joints", self._where, None, arm, rails, duration=duration, share=share, spot=spot))

    def _add(self, move: Move) -> None:
        line = self.line if isinstance(self.line, int) else 0
        here = replace(move, tool=self.tool, base=self.base, load=self.load, line=line, anew=self._anew)
        self.moves.append(here)
        self._anew = False

    def anew(self) -> None:
        """A program begins that nothing calls: the arm may come from anywhere."""
        self._anew = bool(self.moves)

    @property
    def _where(self) -> str:
        return f"{self.place} line {self.line}" if self.line != "" else self.place

    def wait(self, seconds: float) -> None:
        """A standstill at the last point."""
        last = len(self.moves) - 1
        self._dwell[last] = self._dwell.get(last, 0.0) + seconds

    def elsewhere(self, name: str, text: str) -> None:
        """The tool or base (`name`) that holds from here on stands on the controller, not in the file."""
        setattr(self, name, Frame(None, text, f"{self._where}: {text}"))

    def fault(self, line: int | str, what: str, mend: str = "") -> None:
        where = f" line {line}" if isinstance(line, int) else f" {line}" if line else ""
        fault = Fault(f"{self.place}{where}", what, mend)
        if fault not in self.faults:  # of a program that is called twice
            self.faults.append(fault)

    def remark(self, what: str) -> None:
        """Something at this line that does not keep the motions from being read, and that a user of these
        should know."""
        self.remarks.append(Fault(self._where, what))

    def program(self) -> Program:
        """The program read; `InputError` with all faults."""
        poses = [i for i, move in enumerate(self.moves) if move.kind == "pose"]
        faults = list(self.faults)
        if not self.moves and not faults:
            faults = [Fault(self.place, "has no motion", "check that this is the right file and format")]
        if poses and len(poses) != poses[-1] - poses[0] + 1:
            between = next(i for i in range(poses[0], poses[-1]) if i not in set(poses))
            what = "a joint move inside the path"
            faults.append(Fault(self.moves[between].place, what, "split the program"))
        elsewhere = [self.moves[i].base for i in poses if self.moves[i].base.name]
        if elsewhere:
            what = "the base of the path stands on the controller, not in the file"
            faults.append(Fault(elsewhere[0].place, what, "export the path in the robot's world"))
        chosen = poses or list(range(len(self.moves)))
        for name in ("tool", "base"):
            frames = [getattr(self.moves[i], name) for i in chosen]
            if len({(frame.name, frame.matrix.tobytes()) for frame in frames}) > 1:
                faults.append(Fault(self.place, f"the {name} changes inside the path", "split the program"))
        if faults:
            raise InputError(faults)
        return self._path(poses) if poses else self._targets()

    def _dwells(self, chosen: list[int]) -> Array:
        return np.array([self._dwell.get(i, 0.0) for i in chosen])

    def _rails(self, moves: list[Move]) -> Array:
        if len({len(move.rails) for move in moves}) > 1:
            raise InputError(Fault(self.place, "rails (external axes) are given for some points only"))
        return np.array([move.rails for move in moves]).reshape(len(moves), -1)

    def _share(self) -> float:
        """That of the last joint move that says one."""
        said = [move.share for move in self.moves if 0 < move.share <= 1]
        return said[-1] if said else 0.1

    def _path(self, chosen: list[int]) -> Program:
        moves, dwell = [self.moves[i] for i in chosen], self._dwells(chosen)
        base, rails = moves[0].base.matrix, self._rails(moves)
        X = np.array([base @ move.X for move in moves if move.X is not None])
        straight = np.full((4, 4), np.nan)
        via = np.array([straight if move.via is None else base @ move.via for move in moves])
        speed, turn, duration, blend = np.array(
            [(move.speed, move.turn, move.duration, move.blend) for move in moves]
        ).T
        bent = via if np.isfinite(via).any() else None
        ways = legs_of(Program("ways", X, via=bent))
        with np.errstate(divide="ignore", invalid="ignore"):
            by_speed = np.where(ways.distance < STANDSTILL, ways.angle / turn, ways.distance / speed)
        standing = (ways.distance < STANDSTILL) & (ways.angle < STANDSTILL)
        leg = np.where(np.isfinite(duration), duration, np.where(standing, 0.0, by_speed))
        time = np.concatenate([[0.0], np.cumsum(leg[1:] + dwell[:-1])])
        return Program(
            self.name,
            X,
            rails if rails.size else None,
            time if np.isfinite(time).all() else None,
            dwell,
            moves[0].tool.matrix,
            sliding=(True,) * rails.shape[1],
            blend=float(blend.max(initial=0.0)),
            share=self._share(),
            base=base,
            load=self.load,
            via=bent,
        )

    def _targets(self) -> Program:
        moves, dwell = self.moves, self._dwells(list(range(len(self.moves))))
        rails = self._rails(moves)
        if len({len(move.arm) for move in moves}) > 1:
            raise InputError(Fault(self.place, "joint targets have different numbers of joints"))
        arm = np.array([move.arm for move in moves])
        legs = np.array([move.duration for move in moves[1:]])
        timed = len(legs) > 0 and bool(np.isfinite(legs).all())
        return Program(
            self.name,
            q=np.hstack([rails, arm]),
            time=np.concatenate([[0.0], np.cumsum(legs + dwell[:-1])]) if timed else None,
            dwell=dwell,
            tool=moves[0].tool.matrix,
            kind="joints",
            sliding=(True,) * rails.shape[1] + (False,) * arm.shape[1],
            share=self._share(),
            base=moves[0].base.matrix,
            load=self.load,
        )
