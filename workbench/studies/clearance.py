"""How many of a study's poses the robot could stand in: above the floor that its base stands on, and clear of
itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..campaign.planned import planned, random_poses
from ..campaign.problem import problem_of
from ..report.numbers import decimals
from ..report.study import Table
from ..robot.collisions import FLOOR, Collisions, collisions
from ..robot.description import Robot
from ..robot.hulls import robot_hulls
from ..robot.kinematics import Array

USUAL = 200  # random poses that show what is built to touch
BASE = 0  # slot of the base
TOUCH = 1e-3  # m that the floor lies below the base


@dataclass(frozen=True)
class Clear:
    """Of `poses`: above the floor, clear of itself, both."""

    poses: int
    above: int
    itself: int
    both: int


def clear_poses(robot: Robot, plans: Mapping[str, Array]) -> dict[str, Clear]:
    """plans: what poses are for → q: (N, n) [rad, m]. The robot is bare, as convex hulls of its links,
    without tool and payload."""
    bodies = _bodies(robot)
    found = {}
    for words, q in plans.items():
        pairs = [bodies.touching(one) for one in np.asarray(q, dtype=float)]
        above = np.array([all(FLOOR not in pair for pair in each) for each in pairs], dtype=bool)
        itself = np.array([all(FLOOR in pair for pair in each) for each in pairs], dtype=bool)
        found[words] = Clear(len(pairs), int(above.sum()), int(itself.sum()), int((above & itself).sum()))
    return found


def _bodies(robot: Robot) -> Collisions:
    """The robot's links and the floor at its foot."""
    usual = random_poses(robot, USUAL, np.random.default_rng(0))
    arm = problem_of(planned(robot, usual[:1])).arm
    hulls = robot_hulls(robot, arm)
    foot = min((float(hull.vertices[:, 2].min()) for hull in hulls if hull.slot == BASE), default=0.0)
    return collisions(robot, arm, hulls, foot - TOUCH, 0.0, usual)


def clear_table(found: Mapping[str, Clear]) -> Table:
    """What the poses are for, and how many the robot could stand in."""
    rows = [
        [words, *(decimals(float(n), 0) for n in (one.poses, one.above, one.itself, one.both))]
        for words, one in found.items()
    ]
    note = (
        "Convex hulls of the bare robot’s links in Drake, without tool, payload and cell; floor: at the foot "
        "of the base."
    )
    head = ("Poses", "Number", "Above the floor", "Clear of itself", "Both")
    return Table("Poses that the robot could stand in", head, rows, note)


def clear_numbers(found: Mapping[str, Clear]) -> dict[str, float]:
    """For a story: how many poses there are, and how many are above the floor, clear of the robot itself, and
    both."""
    keys = ("poses", "above", "itself", "both")
    total = {key: float(sum(getattr(one, key) for one in found.values())) for key in keys}
    return {f"clear_{key}": count for key, count in total.items()}
