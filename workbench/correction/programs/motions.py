"""The motions that a reader collects while it goes through a controller's file; becomes a `Program`."""

from __future__ import annotations

import numpy as np

from ...files.faults import Fault, InputError
from .base import STANDSTILL, Array, Program, legs_of


class Motions:
    """Motions in the order of the file, with what the file says of the way to each.

    A program with poses is a path: joint moves before its first pose bring the arm there and those
    after it bring the arm away; neither are points of the path.
    """

    def __init__(self, place: str) -> None:
        self.place = place
        self.name = ""
        self.tool = np.eye(4)
        self.faults: list[Fault] = []
        self._poses: list[tuple[Array, tuple[float, ...], float, float, float, float]] = []
        self._joints: list[tuple[tuple[float, ...], tuple[float, ...], float]] = []
        self._dwell: dict[tuple[str, int], float] = {}
        self._last = ("start", 0)

    def pose(
        self,
        X: Array,
        rails: tuple[float, ...] = (),
        speed: float = np.nan,
        turn: float = np.nan,
        duration: float = np.nan,
        blend: float = 0.0,
    ) -> None:
        """A tool pose (4, 4); tool speed [m/s], turning speed [rad/s] or time of the leg [s]; corner [m]."""
        if self._poses and self._last[0] == "joints":
            self.fault(
                f"before pose {len(self._poses) + 1}", "a joint move inside the path", "split the program"
            )
        self._poses.append((X, rails, speed, turn, duration, blend))
        self._last = ("pose", len(self._poses) - 1)

    def joints(self, arm: tuple[float, ...], rails: tuple[float, ...] = (), share: float = np.nan) -> None:
        """Joint targets: turning joints [rad], rails [m], share of the full speed."""
        self._joints.append((arm, rails, share))
        self._last = ("joints", len(self._joints) - 1)

    def wait(self, seconds: float) -> None:
        """A standstill at the last point."""
        self._dwell[self._last] = self._dwell.get(self._last, 0.0) + seconds

    def fault(self, line: int | str, what: str, mend: str = "") -> None:
        where = f" line {line}" if isinstance(line, int) else f" {line}" if line else ""
        self.faults.append(Fault(f"{self.place}{where}", what, mend))

    def program(self) -> Program:
        """The program read; `InputError` with all faults."""
        if not self._poses and not self._joints and not self.faults:
            self.fault("", "has no motion", "check that this is the right file and format")
        if self.faults:
            raise InputError(self.faults)
        return self._path() if self._poses else self._targets()

    def _dwells(self, kind: str, count: int) -> Array:
        return np.array([self._dwell.get((kind, i), 0.0) for i in range(count)])

    def _rails(self, rails: list[tuple[float, ...]]) -> Array:
        if len({len(row) for row in rails}) > 1:
            raise InputError(Fault(self.place, "rails (external axes) are given for some points only"))
        return np.array(rails).reshape(len(rails), -1)

    def _path(self) -> Program:
        X = np.array([row[0] for row in self._poses])
        rails = self._rails([row[1] for row in self._poses])
        speed, turn, duration, blend = np.array([row[2:] for row in self._poses]).T
        dwell = self._dwells("pose", len(X))
        ways = legs_of(Program("ways", X))
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
            self.tool,
            sliding=(True,) * rails.shape[1],
            blend=float(blend.max(initial=0.0)),
        )

    def _targets(self) -> Program:
        rails = self._rails([row[1] for row in self._joints])
        if len({len(row[0]) for row in self._joints}) > 1:
            raise InputError(Fault(self.place, "joint targets have different numbers of joints"))
        arm = np.array([row[0] for row in self._joints])
        share = self._joints[-1][2]
        return Program(
            self.name,
            q=np.hstack([rails, arm]),
            dwell=self._dwells("joints", len(arm)),
            tool=self.tool,
            kind="joints",
            sliding=(True,) * rails.shape[1] + (False,) * arm.shape[1],
            share=share if 0 < share <= 1 else 0.1,
        )
