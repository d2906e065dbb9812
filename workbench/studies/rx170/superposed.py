"""Height of the tool along the spiral as a sum of causes: small errors add up, so each is computed once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from workbench import Array, EffectRecord, Path, Robot, load_robot, path_shapes, planned, problem_of, restated

from .causes import standing_error
from .printed import ACCELERATION, HEIGHT, SPEED, SPIRAL, SPIRAL_TURNS, SWEPT, TABLE_1

BASE_TO_JOINT_2 = 0.75  # m: the maker counts Z from the height of joint 2
PLANE = BASE_TO_JOINT_2 + HEIGHT  # m over the floor: of the spiral
ELBOW_UP = np.array([0.0, 0.4, 1.8, 0.0, 0.95, 0.0])
UNIT = 1e-5  # rad, of the gears below
PLACES = (0.9, 1.0, 1.1)  # m from axis 1
SPACING = 2e-3  # m between samples
GEARS = {
    "joint_2": 200.0,
    "joint_3": 200.0,
    "joint_5": 88.0,
}  # cycles per joint turn; those that lift the tool


@dataclass(frozen=True, eq=False)
class Heights:
    """Of N samples, in mm.

    plane: (N, 3) columns x, y, 1; yield_2, yield_others: (N,) with the model's stiffness and masses; gear:
    joint → (N, 2) cosine and sine of UNIT.
    """

    plane: Array
    yield_2: Array
    yield_others: Array
    gear: Mapping[str, Array]


@cache
def sweep_span() -> float:
    """[°] what joint 2 yields from end to end of the paper's sweep, with the model's masses and spring."""
    q = np.zeros((101, 6))
    q[:, 1], q[:, 2] = np.deg2rad(np.linspace(*SWEPT, 101)), np.deg2rad(90)
    problem = problem_of(planned(load_robot("rx170"), q, targets=()))
    torque = problem.nominal_load.local.reshape(len(q), -1)[:, problem.arm.axial[1]]
    return float(np.degrees(np.ptp(torque) / TABLE_1[1]))


def spiral_at(place: float, speed: float, turns: float, spacing: float) -> Path:
    """The paper's spiral so far [m] before axis 1, hand down, at a speed [m/s] that is reached in the same
    time as the printed one; spacing: [m] between samples."""
    frame = path_shapes.work_frame([place, 0.0, PLANE])
    run = path_shapes.Run(frame, speed, ACCELERATION * speed / SPEED, spacing / speed)
    return path_shapes.spiral(run, **SPIRAL, angle=2 * np.pi * turns)


@cache
def heights_at(place: float) -> Heights:
    """The spiral so far [m] before the robot."""
    path = spiral_at(place, SPEED, SPIRAL_TURNS, SPACING)
    robot = load_robot("rx170")
    others = [name for name in robot.joint_names if name != "joint_2"]

    def height(one: Robot) -> Array:
        return np.asarray(1e3 * standing_error(one, path, ELBOW_UP)[:, 2])

    def turned(joint: str, phase: float) -> Array:
        size = {"amplitude": UNIT, "phase": phase}
        line = EffectRecord(cause="gear_kinematic_error", joint=joint, order=GEARS[joint], values=size)
        return height(replace(restated(robot, stiffness=None), effects=(line,)))

    yield_2 = height(restated(robot, others, stiffness=None))
    n = len(yield_2)
    turn = np.linspace(0, 2 * np.pi * SPIRAL_TURNS, n)
    reach = SPIRAL["start"] * np.exp(SPIRAL["growth"] * turn)
    return Heights(
        np.column_stack([reach * np.cos(turn), reach * np.sin(turn), np.ones(n)]),
        yield_2,
        height(restated(robot, ["joint_2"], stiffness=None)),
        {joint: np.column_stack([turned(joint, 0.0), turned(joint, np.pi / 2)]) for joint in GEARS},
    )
