"""How many poses the geometry of a robot needs; how many the place of an instrument beside a known robot."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...campaign.problem import Problem
from ...files.faults import Fault, InputError
from ..iso_9283 import repeatability

ROOM = 3.0  # times as many measured numbers as the geometry has: fewer show little besides
FRAME = 6  # numbers of an instrument's place


def enough_poses(problem: Problem) -> list[str]:
    """A remark where the poses say little more than the geometry itself. Raises InputError where they do not
    even identify that: 4 numbers per turning joint, 2 per sliding one, 6 for base and tool."""
    poses, measured, hand = _counted(problem)
    geometry = _links(problem) + hand
    if measured >= ROOM * geometry or not hand:
        return []
    wanted = math.ceil(ROOM * geometry / hand)
    name = problem.robot.name
    said = (
        f"{poses} different poses give {measured} numbers, geometry, base and tool of {name} have {geometry}"
    )
    if measured < geometry:
        mend = f"measure {wanted} poses or more: workbench plan {name} --poses {wanted}"
        if repeatability(problem):
            mend += "; workbench check tells how they repeat"
        raise InputError(Fault(str(problem.campaign.path), f"{said}: they do not identify it", mend))
    return [f"{said}: what these poses do not show may well be there. {wanted} poses would show it."]


def measured_and_needed(problem: Problem) -> tuple[int, int]:
    """How many numbers its different poses measure, and how many the geometry has."""
    _, measured, hand = _counted(problem)
    return measured, _links(problem) + hand


def too_few_alone(problem: Problem) -> bool:
    """Whether the poses do not identify the geometry by themselves."""
    measured, needed = measured_and_needed(problem)
    return 0 < measured < needed


def enough_beside_others(problem: Problem) -> list[str]:
    """A remark as of `enough_poses`; of a campaign that is compared with others of the same robot, whose
    geometry it need not identify. Raises InputError where instrument and targets take all that it shows."""
    if not too_few_alone(problem):
        return enough_poses(problem)
    poses, measured, hand = _counted(problem)
    placed = _placed(problem, hand)
    said = f"{poses} different poses give {measured} numbers"
    if measured <= placed:
        what = f"{said}, where instrument and targets are has {placed}: nothing is left to show the robot"
        wanted = placed // hand + 1
        raise InputError(Fault(str(problem.campaign.path), what, f"measure {wanted} poses or more"))
    return [
        f"{said}, {placed} of them say where instrument and targets are: the robot's geometry comes from the "
        f"other campaigns, and {measured - placed} numbers show whether it changed. A wild point among so "
        "few would not be noticed."
    ]


def enough_together(problems: Sequence[Problem]) -> None:
    """Raises InputError where campaigns of one robot, each with too few poses alone, do not identify its
    geometry together: once for all, instrument and targets for each."""
    if not all(too_few_alone(problem) for problem in problems):
        return
    counted = [_counted(problem) for problem in problems]
    poses, measured = sum(n for n, _, _ in counted), sum(m for _, m, _ in counted)
    placed = sum(_placed(problem, hand) for problem, (_, _, hand) in zip(problems, counted, strict=True))
    first = problems[0]
    needed = _links(first) - FRAME + placed
    if measured < needed:
        name = first.robot.name
        what = (
            f"{poses} different poses of all campaigns give {measured} numbers, the geometry of {name} and "
            f"where instruments and targets are have {needed}: they do not identify it"
        )
        wanted = math.ceil(ROOM * (_links(first) + counted[0][2]) / counted[0][2])
        mend = f"add a campaign of {wanted} poses or more: workbench plan {name} --poses {wanted}"
        raise InputError(Fault(str(first.campaign.path), what, mend))


def _counted(problem: Problem) -> tuple[int, int, int]:
    """Different poses, numbers that they measure of the hand, and the most that one of them does."""
    _, first = np.unique(problem.positions, return_index=True)
    moving = np.array(problem.on) > 0
    # one target shows three motions of the hand, two show five, three and more all six
    shown = np.array([0, 3, 5, 6])[np.minimum(problem.seen[first][:, moving].sum(axis=1), 3)]
    return len(first), int(shown.sum()), int(shown.max(initial=0))


def _links(problem: Problem) -> int:
    """Numbers of the geometry with the base, without what the targets show of the hand."""
    sliding = int(problem.arm.prismatic.sum())
    return 4 * (problem.arm.n - sliding) + 2 * sliding


def _placed(problem: Problem, hand: int) -> int:
    """Numbers of instrument and targets, those of each set-up; fixed targets have none."""
    moving = [t for t, slot in zip(problem.campaign.targets, problem.on, strict=True) if slot > 0]
    own = 0 if all(target.fixed for target in moving) else hand
    return len(problem.campaign.setup_names) * (FRAME + own)
