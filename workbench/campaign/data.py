"""The campaign as arrays: what the robot was told, beside what the instrument saw. SI units."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..robot.description import Robot

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Target:
    """What the instrument looks at. `xyz`: nominal place in the frame of `on`, None = unknown.

    `on` is "flange", "base" or the name of a link; `fixed`: the place is not re-fitted.
    """

    name: str
    xyz: tuple[float, float, float] | None = None
    on: str = "flange"
    fixed: bool = False


@dataclass(frozen=True, eq=False)
class Campaign:
    """Measured or simulated data of one robot. N poses, n joints, T targets, P payloads.

    Every pose has at least one measured target, and every target was measured at least once.

    pose_ids          N names
    q                 (N, n) commanded joints, rad or m
    payload           (N,) index into payload_names; 0 is "", the tool only
    load_mass         (P,), load_com (P, 3): the payload itself without the tool, flange frame
    tool_mass         always mounted, tool_com (3,) in the flange frame
    wrench            (N, 6) fx fy fz mx my mz on the robot at the flange origin, base frame
    direction         (N, n) sign of the last motion, -1 0 +1 (0: none or not known); None: not given
    time              (N,) s, temperature (N,) degC, torque (N, n) N·m, readback (N, n):
                      None when not given at all, NaN where a cell is empty
    setup             (N,) index into setup_names ("" when the file names none)
    points            (N, T, 3) mean of the shots, instrument frame; NaN = not seen
    shots             (N, T) number of shots behind each mean
    sigma             (N, T, 3) one sigma of the mean, NaN where not seen; None: not stated per
                      point. Where given it counts, not noise_sigma
    shot_scatter      sum of squares of the shots about their means over all axes [m²], and its
                      degrees of freedom
    noise_sigma       one sigma per axis of one shot, stated for all; None: not stated
    six_dof           the targets of a pose are points of one 6-D measurement
    files             "<folder>/<file>" -> sha256
    """

    title: str
    path: Path
    robot: Robot
    pose_ids: tuple[str, ...]
    q: Array
    payload: IntArray
    payload_names: tuple[str, ...]
    load_mass: Array
    load_com: Array
    tool_mass: float
    tool_com: Array
    wrench: Array
    direction: Array | None
    time: Array | None
    temperature: Array | None
    torque: Array | None
    readback: Array | None
    setup: IntArray
    setup_names: tuple[str, ...]
    targets: tuple[Target, ...]
    points: Array
    shots: IntArray
    sigma: Array | None = None
    shot_scatter: tuple[float, int] = (0.0, 0)
    noise_sigma: float | None = None
    six_dof: bool = False
    warnings: tuple[str, ...] = ()
    files: dict[str, str] = field(default_factory=dict)

    @property
    def n_poses(self) -> int:
        return len(self.pose_ids)

    @property
    def n_points(self) -> int:
        """Measured points, shots counted once."""
        return int(np.count_nonzero(self.shots))

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(N, T) which target was measured at which pose."""
        return self.shots > 0

    def some(self, chosen: NDArray[np.int64]) -> Campaign:
        """Only these poses, in this order."""

        def of(column: Array | None) -> Array | None:
            return None if column is None else column[chosen]

        return replace(
            self,
            pose_ids=tuple(self.pose_ids[i] for i in chosen),
            q=self.q[chosen],
            payload=self.payload[chosen],
            wrench=self.wrench[chosen],
            direction=of(self.direction),
            time=of(self.time),
            temperature=of(self.temperature),
            torque=of(self.torque),
            readback=of(self.readback),
            setup=self.setup[chosen],
            points=self.points[chosen],
            shots=self.shots[chosen],
            sigma=of(self.sigma),
        )

    @property
    def folder(self) -> str:
        """The name of the folder that the campaign lies in: short, for labels."""
        return self.path.resolve().parent.name
