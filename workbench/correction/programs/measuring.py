"""Programs that bring the arm to poses to be measured: by joints, from a known side, with a standstill."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...files.faults import Fault, InputError
from ...robot.description import Robot
from ...robot.kinematics import Array
from ...robot.schema import LoadData
from ..trouble import ranges_of
from .base import Program
from .format import Format
from .shown import as_shown

APPROACH = np.radians(2.0), 0.01  # how far before a pose the arm comes to: turning [rad], sliding joints [m]
DWELL_S = 4.0
SHARE = 0.1


def measuring_program(
    robot: Robot,
    q: Array,
    format: Format,
    dwell_s: float = DWELL_S,
    *,
    sides: Array | None = None,
    via: Sequence[Sequence[Array]] = (),
    name: str = "measure",
    load: LoadData | None = None,
    share: float = SHARE,
    as_urdf: bool = False,
) -> Program:
    """A program of joint targets for a robot's controller: to each of N poses by an approach point.

    q: (N, n) the URDF's joints [rad, m]. dwell_s: standstill at a pose [s]; approach points have none.
    sides: (N, n) sign of each joint's last motion (default: all arrive upwards), so that play and friction
    are the same at every return. via: (N) poses (n,) on the way to each, passed without a standstill
    (default: none). load: what the flange carries. Raises `InputError` for joints out of range and for a
    robot without `[controller]`.
    """
    q = np.asarray(q, dtype=float)
    limits = ranges_of(robot)
    out = np.argwhere((q < limits.lower - 1e-9) | (q > limits.upper + 1e-9))
    if len(out):
        told = [Fault(f"pose {i + 1}: {robot.joints[j].name}", "is out of its range") for i, j in out]
        raise InputError(told)
    if not dwell_s > 0:
        raise InputError(
            Fault("dwell", f"is {dwell_s} s", "give more than zero: the robot has to stand still")
        )
    before = approaches(robot, q, np.ones_like(q) if sides is None else np.asarray(sides, dtype=float))
    ways = [(*over, a, b) for over, a, b in zip(via or [()] * len(q), before, q, strict=True)]
    program = Program(
        format.legal_name(name),
        q=np.array([stop for way in ways for stop in way]),
        dwell=np.array([pause for way in ways for pause in [0.0] * (len(way) - 1) + [dwell_s]]),
        kind="joints",
        sliding=robot.sliding,
        share=share,
        load=load,
    )
    return as_shown(program, robot, as_urdf) if format.own_joints else program


def check_format(robot: Robot, format: Format, as_urdf: bool) -> None:
    """Raises `InputError` where no program of the format drives this robot: to be asked before poses are
    chosen."""
    limits = ranges_of(robot)
    some = np.clip(0.0, limits.lower, limits.upper)[None]
    if faults := format.check(measuring_program(robot, some, format, as_urdf=as_urdf)):
        raise InputError(faults)


def approaches(robot: Robot, q: Array, sides: Array) -> Array:
    """(N, n) where the arm comes to before poses q (N, n), of which sides (N, n) say the last motion."""
    before = q - sides * np.where(robot.sliding, APPROACH[1], APPROACH[0])
    limits = ranges_of(robot)
    return np.clip(before, limits.lower, limits.upper)
