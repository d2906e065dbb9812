"""How many poses the geometry of a robot needs."""

from __future__ import annotations

import math

import numpy as np

from ...campaign.problem import Problem
from ...files.faults import Fault, InputError

ROOM = 3.0  # times as many measured numbers as the geometry has: fewer show little besides


def enough_poses(problem: Problem) -> list[str]:
    """A remark where the poses say little more than the geometry itself. Raises InputError where they do not
    even identify that: 4 numbers per turning joint, 2 per sliding one, 6 for base and tool."""
    c = problem.campaign
    _, first = np.unique(problem.positions, return_index=True)
    moving = np.array(problem.on) > 0
    # one target shows three motions of the hand, two show five, three and more all six
    shown = np.array([0, 3, 5, 6])[np.minimum(problem.seen[first][:, moving].sum(axis=1), 3)]
    hand = int(shown.max(initial=0))
    sliding = int(problem.arm.prismatic.sum())
    geometry = 4 * (problem.arm.n - sliding) + 2 * sliding + 6 - (6 - hand)
    measured, poses = int(shown.sum()), len(first)
    if measured >= ROOM * geometry or not hand:
        return []
    wanted = math.ceil(ROOM * geometry / hand)
    name = problem.robot.name
    said = f"{poses} different poses give {measured} numbers, the geometry of {name} has {geometry}"
    if measured < geometry:
        mend = f"measure {wanted} poses or more: workbench plan {name} --poses {wanted}"
        raise InputError(Fault(str(c.path), f"{said}: they do not identify it", mend))
    return [f"{said}: what these poses do not show may well be there. {wanted} poses would show it."]
