"""The commands that `verify` runs, at each speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...correction.command import Compensation, compensate
from ...correction.paths import Path
from ...files.faults import Fault, InputError
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.rotations import angle_between
from .motion import path_speed
from .outcomes import orders
from .runs import World
from .verification import STILL
from .ways import SAME, way_of

LEAST_TOLD = 1e-9  # rad, m: by which a command has to differ to be run beside another
LONGEST = 60.0  # s that a run may take in the simulated world


@dataclass(eq=False)
class Plans:
    """The commands that are run."""

    world: World
    path: Path
    start: Array | None
    seed: int

    def __post_init__(self) -> None:
        world = self.world
        self.notes: list[str] = []
        self.expected_mm = 0.0
        # geometry and the nominal joints are the same at every speed
        self.geometry = self._compensate(self.path, world.belief, "geometry")
        rows, q = self.geometry.X_desired, self.geometry.q_nominal
        waves = [(joint, order) for _, joint, order in orders(world.truth, world.belief)]
        self.way = way_of(world.belief, self.path, rows, q, world.tool, waves)
        if self.way.uneven:
            where = self.path.place(self.way.uneven[0])
            more = f", nor on {len(self.way.uneven) - 1} more" if len(self.way.uneven) > 1 else ""
            self.notes.append(
                f"behind {where} the arm cannot run straight to the next row{more}: its joints run evenly"
            )

    def _compensate(self, path: Path, robot: Robot, method: str) -> Compensation:
        world = self.world
        loop = world.loop if robot is world.truth else world.believed_loop
        return compensate(
            robot,
            path,
            world.conditions,
            tool=world.tool,
            start=self.start,
            method=method,
            bandwidth_hz=loop.feed_forward_hz,
            seed=self.seed,
        )

    def commands(self, path: Path) -> dict[str, Array]:
        """Joints (M, n) of each variant along the way."""
        world = self.world
        everything = self._compensate(path, world.belief, "exact")
        self.notes += everything.remarks()
        if not self.expected_mm:
            self.expected_mm = float(np.sqrt((everything.after_mm**2).mean()))
        out = {"uncorrected": self.geometry.q_nominal, "corrected": everything.q_command}
        if np.abs(self.geometry.q_command - self.geometry.q_nominal).max() > LEAST_TOLD:
            out["geometry"] = self.geometry.q_command
        if world.truth is not world.belief:
            best = self._compensate(path, world.truth, "exact")
            out["perfect"] = best.q_command
        return {name: self.way.command(q) for name, q in out.items()}

    def at_speeds(self, speeds: Sequence[float] | None) -> tuple[list[tuple[Path, float]], list[str]]:
        """The path at each tool speed, slowest first: its time stretched, within what a run may last. A tool
        that turns and does not move has no speed: 0, in the path's own time."""
        p, time = self.way.rows[:, :3, 3], self.path.time
        own = path_speed(p, time)
        if own <= STILL:
            return self._in_own_time()
        length, found, notes = float(time[-1] - time[0]), {}, []
        for speed in speeds if speeds is not None else (own,):
            stretch = min(own / speed, LONGEST / length)
            if stretch < own / speed:
                took = f"{speed:g} m/s would take {own / speed * length:.0f} s"
                notes.append(f"{took}: run at {own / stretch:.3g} m/s instead")
            found[round(own / stretch, 9)] = replace(
                self.path, time=time[0] + stretch * (time - time[0])
            )  # fmt: skip
        return [(found[speed], speed) for speed in sorted(found)], notes

    def _in_own_time(self) -> tuple[list[tuple[Path, float]], list[str]]:
        """A path along which the tool hardly moves: as it is, within what a run may last."""
        rows, time = self.way.rows, self.path.time
        steps = np.linalg.norm(np.diff(rows[:, :3, 3], axis=0), axis=1)
        turns = angle_between(rows[:-1, :3, :3], rows[1:, :3, :3])
        if max(steps.max(), turns.max()) <= SAME:
            place = self.path.file or self.path.title or "path"
            raise InputError(Fault(place, "the tool does not move", "give a path"))
        share = min(1.0, LONGEST / float(time[-1] - time[0]))
        note = "the tool turns where it is, which no speed in m/s says: run in the path's own time"
        notes = [f"{note}, {share:.3g} times as long" if share < 1 else note]
        return [(replace(self.path, time=time[0] + share * (time - time[0])), 0.0)], notes
