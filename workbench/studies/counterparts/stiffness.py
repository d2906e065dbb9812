"""A stiffness that is identified twice, and at each range of its joint's angle."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np
from scipy import stats

from ...effects.base import Effect
from ...effects.place import Where
from ...report.numbers import decimals, p_value, percent
from ...report.study import Table
from .measured import Estimate, Measured, half_95, jackknife
from .own_yield import OwnYield
from .words import TITLE, micro, within

GROUPS = 6  # of the angle, as in the KR 120's paper
WIDER = 2.0  # times, from where on an interval is not the noise's
LEAST_P = 0.01


def stiffness_twice(robots: Sequence[Measured]) -> Table:
    """Does a compliance come out again, and is it the noise of a reading that limits it?"""
    rows, apart = [], []
    wider: dict[str, list[float]] = {}
    whole: dict[str, list[Estimate]] = {}
    for robot in robots:
        every = robot.fitted(robot.yields)
        parts = []
        for words, half in zip(("every other block", "the others"), robot.halves(every), strict=True):
            found = robot.estimate(every, half=half)
            noise = None if robot.known.noise is None else found.by(robot.known.noise)
            stated = "not stated" if noise is None else micro(noise)
            number = str(int((~half.out).sum()))
            rows.append([robot.known.words, words, number, micro(found.value), stated, micro(found.half)])
            parts.append(found)
            if noise is not None:
                wider.setdefault(robot.known.words, []).append(found.half / noise)
        apart.append(abs(parts[0].value - parts[1].value) / float(np.hypot(parts[0].half, parts[1].half)))
        whole.setdefault(robot.problem.robot.name, []).append(robot.estimate(every))
    agree = "agree within" if max(apart) <= 1 else "do not all agree within"
    note = [
        "Compliance of the joint that lifts the arm; all geometry is fitted beside. Torque: of gravity by "
        "published masses, with the iiwa by its own sensors. 95 % intervals: by the noise that is stated, "
        "and by leaving out blocks of poses in turn, which allows errors that hang together within a block "
        "(not less than by what the model leaves). "
        "An error that all poses share, of a gear or a mass, is in neither.",
        f"The halves {agree} the latter interval.",
    ]
    for name, ratios in wider.items():
        limit = "is not" if min(ratios) > WIDER else "may be"
        note.append(
            f"On the {name} it is {within(ratios)} times as wide as by the noise: the noise of a reading "
            f"{limit} what limits this stiffness."
        )
    for one, other in (pair for found in whole.values() for pair in combinations(found, 2)):
        said = "agree" if abs(one.value - other.value) <= np.hypot(one.half, other.half) else "do not agree"
        each = " and ".join(f"{micro(e.value)} ± {micro(e.half)}" for e in (one, other))
        note.append(f"The two campaigns with an iiwa 7, each as a whole, give {each}: they {said}.")
    head = ("Robot", "Poses", "Number", "µrad/(N·m)", "95 % by noise, ±", "95 % by blocks, ±")
    return Table(TITLE, head, rows, " ".join(note), (2, 3, 4, 5))


def compliance_by_angle(robots: Sequence[Measured]) -> Table:
    """A compliance of its own in each of six ranges of a joint's angle: do they differ, and does a function
    of the angle that has no load in it make them differ?"""
    rows, differ = [], {False: 0, True: 0}
    for robot in robots:
        ends = np.quantile(robot.angle, np.linspace(0, 1, GROUPS + 1))
        angle = " to ".join(decimals(float(np.degrees(end)), 0) for end in ends[[0, -1]]) + "°"
        ends[-1] = np.inf
        ranges = [OwnYield(Where(joint=robot.known.lift), low=low, high=high) for low, high in pairwise(ends)]
        for mapped in (False, True):
            more = robot.functions() if mapped else []
            values, half, p = _six(robot, [*ranges, *robot.yields[1:], *more])
            differ[mapped] += p < LEAST_P
            model = "… and functions of angles" if mapped else "geometry"
            each = [f"{micro(v)} ± {micro(h)}" for v, h in zip(values, half, strict=True)]
            rows.append([robot.known.words, angle, model, *each, p_value(p)])
    note = (
        "None of these joints has a gravity compensator. Compliance of the joint that lifts the arm in six "
        "ranges of its angle with as many poses each, µrad/(N·m), 95 % by leaving out blocks of poses. The p "
        "of equal ones also counts what the six intervals have in common. With geometry alone beside they "
        f"differ (p < {percent(LEAST_P, 0)}) in {differ[False]} of {len(robots)} campaigns, with a function "
        f"of each joint’s angle, which hangs on no load, in {differ[True]}. All poses are under one load: "
        "what differs need not be stiffness."
    )
    head = ("Robot", "Angle", "Beside", *(f"Range {k}" for k in range(1, GROUPS + 1)), "All equal")
    return Table(TITLE, head, rows, note, tuple(range(3, GROUPS + 4)))


def _six(robot: Measured, effects: Sequence[Effect]) -> tuple[list[float], list[float], float]:
    """Values and half intervals of the first `GROUPS` compliances, and p of equal ones (Hotelling's T²)."""
    found = robot.fitted(effects)
    at = [part.start for part in found.columns.effect[:GROUPS]]
    changes = robot.left_out(found)[:, at]
    covariance, blocks = jackknife(changes), len(changes)
    values = np.array([found.state.values[k][0] for k in range(GROUPS)])
    C = np.eye(GROUPS)[1:] - np.eye(GROUPS)[:-1]
    T2 = float(C @ values @ np.linalg.solve(C @ covariance @ C.T, C @ values))
    free = blocks - (GROUPS - 1)
    p = float(stats.f.sf(T2 * free / ((GROUPS - 1) * (blocks - 1)), GROUPS - 1, free))
    return values.tolist(), [half_95(column) for column in changes.T], p
