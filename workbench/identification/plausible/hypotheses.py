"""Mistakes that people make with joints, units, frames and robots, each as a changed sample of the data.

A hypothesis undoes one mistake: where it is right, the rigid robot and the points agree again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, islice, permutations

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from ...robot.description import load_robot
from ...robot.find import list_robots
from ...robot.kinematics import Arm, Array
from ...robot.rigid_plant import arrays
from .misfit import USUAL, Sample, misfit

Undo = Callable[[Sample], Sample]

UNITS = {"metres": 1e3, "centimetres": 10.0, "inches": 25.4, "feet": 304.8}  # mm
MOST_ORDERS = 25  # of targets that are tried
TURN = np.pi / 180


@dataclass(frozen=True)
class Hypothesis:
    """table: where the mistake is ("poses", "points", "targets", "robot"); what it is, and how to mend it;
    undo: the data without it; frame: it is one of all points alike; parts: how many things are wrong."""

    table: str
    what: str
    mend: str
    undo: Undo
    frame: bool = False
    parts: int = 1


LEFT_HANDED = Hypothesis(
    "points",
    "the points are in a left-handed frame: two of x, y, z are exchanged, or one has the wrong sign",
    "exchange the columns, or turn the sign of one",
    lambda data: data.changed(points=data.points * np.array([1.0, 1.0, -1.0])),
    frame=True,
)


def hypotheses(problem: Problem) -> Iterator[Hypothesis]:
    """All mistakes that are looked for, the usual ones first."""
    yield from _units(problem)
    yield from _signs(problem)
    yield from _controllers(problem)
    yield from _offsets(problem)
    yield from _orders(problem)
    yield from _couplings(problem)
    yield from _frames()
    yield from _rows(problem)
    yield from _targets(problem)
    yield from _robots(problem)


def _joints(change: Array, shift: Array | float = 0.0) -> Undo:
    """The sample with joints change @ q + shift; change: (n, n), shift: (n,)."""
    return lambda data: data.changed(q=data.q @ change.T + shift)


def _points(factor: Array | float) -> Undo:
    return lambda data: data.changed(points=data.points * factor)


def _stated(order: Sequence[int], factor: float = 1.0) -> Undo:
    return lambda data: data.changed(stated=data.stated[list(order)] * factor)


def _other_rows(points: Array, rows: NDArray[np.int64]) -> Undo:
    return lambda data: data.changed(points=points[rows[data.rows]][:, data.targets])


def _other_arm(arm: Arm) -> Undo:
    return lambda data: data.changed(arm=arm)


def _scaling(n: int, columns: Sequence[int], factor: float) -> Undo:
    change = np.eye(n)
    change[columns, columns] = factor
    return _joints(change)


def _units(problem: Problem) -> Iterator[Hypothesis]:
    """Joints in other units: all turning ones, all sliding ones, or one column."""
    n, sliding = problem.arm.n, problem.arm.prismatic
    mend = "mend the column's suffix, or say so under `units`"
    degrees = (("degrees, not radians", TURN), ("radians, not degrees", 1 / TURN))
    lengths = tuple((f"{a}, not {b}", factor) for a, b, factor in _lengths())
    for joints, kinds in ((~sliding, degrees), (sliding, lengths)):
        columns = np.flatnonzero(joints).tolist()
        for said, factor in kinds:
            if len(columns) > 1:
                what = f"the numbers of the joints fit the robot only if they are {said}"
                yield Hypothesis("poses", what, mend, _scaling(n, columns, factor))
            for j in columns:
                what = f"the numbers of q{j + 1} fit the robot only if they are {said}"
                yield Hypothesis("poses", what, mend, _scaling(n, [j], factor))


def _lengths() -> Iterator[tuple[str, str, float]]:
    """What they are, what they were taken for, and the factor that undoes it."""
    for name, factor in UNITS.items():
        yield name, "millimetres", factor
        yield "millimetres", name, 1 / factor


def _signs(problem: Problem) -> Iterator[Hypothesis]:
    for j, name in enumerate(problem.arm.names):
        how = "slides the other way" if problem.arm.prismatic[j] else "turns the other way round"
        what = f"{name} {how} than the robot's URDF says"
        mend = f"turn the sign of q{j + 1}, or of the joint's axis in the URDF"
        yield Hypothesis("poses", what, mend, _scaling(problem.arm.n, [j], -1.0))


def _controllers(problem: Problem) -> Iterator[Hypothesis]:
    """Joints as the robot's own `[controller]` counts them."""
    convention = problem.robot.convention
    if convention is None or convention.counts_as_the_urdf:
        return
    what = "the columns count the joints as the robot's controller does, not as its URDF does"
    mend = 'say joints = "controller" under [poses]'
    yield Hypothesis("poses", what, mend, lambda data: data.changed(q=convention.joints(data.q)))


def _offsets(problem: Problem) -> Iterator[Hypothesis]:
    """The first joint's zero is the instrument's frame: not seen."""
    for j, name in enumerate(problem.arm.names):
        if problem.arm.prismatic[j]:
            continue
        for degrees in (90, -90, 180, 45, -45):
            shift = TURN * degrees * np.eye(problem.arm.n)[j]
            what = f"{name} has its zero {-degrees:+d}° from where the robot's URDF has it"
            undo = _joints(np.eye(problem.arm.n), shift)
            yield Hypothesis("poses", what, f"add {degrees:+d}° to q{j + 1}", undo)


def _orders(problem: Problem) -> Iterator[Hypothesis]:
    """Two columns exchanged, or all in the other order or by one too far."""
    one = np.eye(problem.arm.n)
    every = list(range(problem.arm.n))
    for i, j in combinations(every, 2):
        columns = every.copy()
        columns[i], columns[j] = j, i
        what = f"{problem.arm.names[i]} and {problem.arm.names[j]} are exchanged"
        yield Hypothesis("poses", what, f"exchange the columns q{i + 1} and q{j + 1}", _joints(one[columns]))
    if len(every) > 2:
        what, mend = "the joints come in the other order", "turn the order of the columns"
        yield Hypothesis("poses", what, mend, _joints(one[::-1]))
        for by in (1, -1):
            what = f"the joints are shifted by one column to the {'right' if by > 0 else 'left'}"
            yield Hypothesis("poses", what, "mend the columns", _joints(np.roll(one, -by, axis=0)))


def _couplings(problem: Problem) -> Iterator[Hypothesis]:
    """A controller's joint that counts from another one's link, or the other way."""
    sliding, names = problem.arm.prismatic, problem.arm.names
    for i, j in permutations(range(problem.arm.n), 2):
        if abs(i - j) > 2 or sliding[i] or sliding[j]:
            continue
        for sign, word in ((1.0, "plus"), (-1.0, "minus")):
            change = np.eye(problem.arm.n)
            change[j, i] = sign
            what = (
                f"{names[j]} of the robot's URDF is q{j + 1} {word} q{i + 1}: the controller couples the two"
            )
            mend = f"write q{j + 1} {word} q{i + 1} into the column q{j + 1}"
            yield Hypothesis("poses", what, mend, _joints(change))


def _frames() -> Iterator[Hypothesis]:
    """Points in other units, all or one column, and left-handed frames."""
    mend = "mend the column's suffix, or say so under `units`"
    for name, said, factor in _lengths():
        what = f"the numbers of the points fit the robot only if they are {name}, not {said}"
        yield Hypothesis("points", what, mend, _points(factor), frame=True)
        for axis in range(3):
            what = f"the numbers of {'xyz'[axis]} fit the robot only if they are {name}, not {said}"
            yield Hypothesis("points", what, mend, _points(factor ** np.eye(3)[axis]))
    yield LEFT_HANDED


def _rows(problem: Problem) -> Iterator[Hypothesis]:
    """Points against the poses of other rows."""
    points, rows = problem.campaign.points, np.arange(len(problem.q))
    for by in (1, -1):
        what = f"every point belongs to the pose {'before' if by > 0 else 'after'} the one that it names"
        mend = "one table lacks a row, or has one too many: mend pose_id"
        yield Hypothesis("points", what, mend, _other_rows(points, np.roll(rows, -by)))
    what, mend = "the points come in the other order than the poses", "turn the order of one table"
    yield Hypothesis("points", what, mend, _other_rows(points, rows[::-1]))


def _targets(problem: Problem) -> Iterator[Hypothesis]:
    """Places of the targets stated for one another, or in other units."""
    targets, mend = problem.campaign.targets, "mend xyz_mm; here they are used so mended"
    moving = [i for i, slot in enumerate(problem.on) if slot > 0] or list(range(len(targets)))
    for order in islice(permutations(range(len(moving))), 1, MOST_ORDERS):
        names = [targets[moving[i]].name for i, other in enumerate(order) if other != i]
        what = f"the places of the targets {', '.join(names)} are stated for one another"
        yield Hypothesis("targets", what, mend, _stated(order))
    farthest = float(np.max(np.linalg.norm(np.nan_to_num(problem.stated_targets[moving]), axis=1)))
    for name, said, factor in _lengths():
        if factor * farthest < 3 * USUAL:  # at the flange's middle any wrong place would be "right"
            continue
        what = f"the places of the targets fit only if they are {name}, not {said}"
        yield Hypothesis("targets", what, mend, _stated(range(len(moving)), factor))


def placed_elsewhere(data: Sample) -> Iterator[Hypothesis]:
    """That the targets sit where the points alone have them, far from where they are stated."""
    free = misfit(data.changed(stated=np.full_like(data.stated, np.nan)), turns=True)
    known = np.isfinite(data.stated).all(axis=1)
    if not known.any() or not free.placed:
        return
    found = free.placed[0].targets
    off = (found - data.stated)[known]
    shift = off.mean(axis=0)
    said = f"up to {1e3 * np.linalg.norm(off, axis=1).max():.0f} mm"
    if np.linalg.norm(off - shift, axis=1).max() < USUAL:
        said = f"({', '.join(f'{round(1e3 * float(part)):+d}' for part in shift)}) mm"
    what = f"the targets sit {said} from where they are stated, as if these were places in another frame"
    mend = "state xyz_mm in the flange's frame, not in a tool's; here they are used as found"
    yield Hypothesis("targets", what, mend, lambda sample: sample.changed(stated=found))


def _robots(problem: Problem) -> Iterator[Hypothesis]:
    """Other robots that come with the workbench and have as many joints of the same kinds."""
    for path in list_robots():
        robot = load_robot(path)
        if robot.urdf == problem.robot.urdf or robot.sliding != problem.robot.sliding:
            continue
        arm, ours = arrays(robot), problem.robot
        what = f"the points fit {robot.title} ({robot.name}), not {ours.title} ({ours.name})"
        yield Hypothesis("robot", what, f'say robot = "{robot.name}"', _other_arm(arm))
