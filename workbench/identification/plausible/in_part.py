"""Mistakes of a part of a campaign: most of its poses fit the robot, the others do not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice, permutations

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..registration import Placed, place, sight, spread_of
from .hypotheses import MOST_ORDERS, Hypothesis, Undo
from .misfit import BOUND, Sample, held, misfit

FEWEST = 8  # poses of each part
WIDE = 0.5  # of the spread of all points at least: what hardly moves fits any robot
DRAWN = 4  # poses that place an instrument and its targets, drawn
DRAWS = 120  # of these, every other among a few in a row: mistakes mostly begin somewhere and end somewhere;
# where half of the poses fit, here and there, the others miss them in 2 % of cases
ROUGHLY = 6  # iterations for each, and of
ROUNDS = 3  # placements by all poses that agree
BLOCK = 0.75  # of the poses between the first and the last that do not fit: all of these are meant
SHOWN = 3  # poses by their ids

Rows = NDArray[np.bool_]


@dataclass(frozen=True)
class Part:
    """Poses that do not fit while all others do. rows: (N,) of the sample; where: they in words; placed: the
    set-up by the others; limit: [m] from which a point does not fit."""

    rows: Rows
    where: str
    placed: Placed
    limit: float


def not_fitting(problem: Problem, data: Sample, enough: float) -> Part | None:
    """The poses of a sample of one set-up that do not fit, where the others leave no more than `enough`.

    The set-up is placed by a few poses, drawn again and again, until most of the others agree (Fischler &
    Bolles 1981): however many poses are wrong, some draws have none of these.
    """
    count = len(data.rows)
    if len(np.unique(data.setup)) > 1 or count < 2 * FEWEST:
        return None
    chance, best, least = np.random.default_rng(count), misfit(data).placed[0], np.inf
    spread = _spread(data, best)
    limit = BOUND * spread
    for draw in range(DRAWS + 1):
        first = chance.integers(count - FEWEST + 1)
        among = np.arange(first, first + FEWEST) if draw % 2 else np.arange(count)
        placed = best if not draw else _placed(data, chance.permutation(among)[:DRAWN], ROUGHLY)
        off = _off(data, placed)
        left = float(np.minimum(off, limit).mean())
        if left < least:
            best, least = placed, left
        if np.mean(off <= limit) > 0.5 and np.median(off) <= enough * spread:
            break
    agree = np.zeros(count, bool)
    for _ in range(ROUNDS):
        agree = _off(data, best) <= limit
        if agree.sum() < FEWEST:
            return None
        best = _placed(data, np.flatnonzero(agree))
    if count - agree.sum() < FEWEST:
        return None
    fitting = data.only(np.flatnonzero(agree))
    if _spread(fitting, best) < WIDE * spread or misfit(fitting).total > enough:
        return None
    return _told(problem, data, best, limit)


def _told(problem: Problem, data: Sample, placed: Placed, limit: float) -> Part:
    """Which poses of the whole campaign are farther off than a limit [m]: nearly all from one to another, or
    some here and there."""
    c = problem.campaign
    every = data.changed(
        rows=np.arange(len(problem.q)), q=problem.q, points=c.points[:, data.targets], setup=c.poses.setup
    )
    off = _off(every, placed)
    wrong, seen = off > limit, int(np.isfinite(off).sum())
    first, last = np.flatnonzero(wrong)[[0, -1]]
    ids = c.poses.ids
    if wrong.sum() >= BLOCK * (last - first + 1):
        wrong[first : last + 1] = True
        return Part(wrong[data.rows], f"the poses {ids[first]} … {ids[last]}", placed, limit)
    shown = ", ".join(ids[n] for n in np.flatnonzero(wrong)[:SHOWN])
    return Part(wrong[data.rows], f"{wrong.sum()} of {seen} poses ({shown} … {ids[last]})", placed, limit)


def in_part(problem: Problem, data: Sample, part: Part, every: Iterable[Hypothesis]) -> Iterator[Hypothesis]:
    """That the instrument or the tool stands elsewhere there, or another mistake was made there alone: only
    such as bring most of these poses to where the others have the instrument."""
    what = f"the instrument or the tool stands elsewhere at {part.where}"
    mend = "give these poses a name of their own in a column setup"

    def apart(sample: Sample) -> Sample:
        return sample.changed(setup=sample.setup + part.rows, stated=np.full_like(sample.stated, np.nan))

    yield Hypothesis("poses", what, mend, apart, parts=2)  # where it stands, and with which targets
    for one in (*every, *_axes(), *_names(problem, data)):
        alike = one.table in ("poses", "points")
        if alike and np.mean(_off(one.undo(data), part.placed)[part.rows] <= part.limit) > 0.5:
            yield _there(one, part)


def _axes() -> Iterator[Hypothesis]:
    """Axes of the points other than those of all others: of a whole campaign they are its frame."""
    for i, j in combinations(range(3), 2):
        order = [j if k == i else i if k == j else k for k in range(3)]
        what = f"{'xyz'[i]} and {'xyz'[j]} of the points are exchanged"
        yield Hypothesis("points", what, "exchange them back", _turned(np.eye(3)[order]))
    for i in range(3):
        what = f"{'xyz'[i]} of the points has the other sign"
        yield Hypothesis("points", what, "turn it", _turned(np.diag(1.0 - 2.0 * np.eye(3)[i])))


def _names(problem: Problem, data: Sample) -> Iterator[Hypothesis]:
    """Names of targets on one body that are exchanged; of a whole campaign their stated places are. Where few
    are seen at a time no distances between them say so."""
    on = [problem.on[i] for i in data.targets]
    for order in islice(permutations(range(len(on))), 1, MOST_ORDERS):
        moved = [i for i, other in enumerate(order) if other != i]
        if len({on[i] for i in moved}) > 1:
            continue
        names = [problem.campaign.targets[data.targets[i]].name for i in moved]
        what = f"the names of the targets {', '.join(names[:-1])} and {names[-1]} are exchanged"
        mend = "exchange them in the column target"
        yield Hypothesis("points", what, mend, _ordered(order))


def _ordered(order: Sequence[int]) -> Undo:
    """The sample with points of targets in this order."""
    return lambda data: data.changed(points=data.points[:, list(order)])


def _turned(axes: Array) -> Undo:
    """The sample with points axes @ point; axes: (3, 3)."""
    return lambda data: data.changed(points=data.points @ axes.T)


def _there(one: Hypothesis, part: Part) -> Hypothesis:
    """The mistake at a part of the poses."""

    def undo(data: Sample) -> Sample:
        mended, q, points = one.undo(data), data.q.copy(), data.points.copy()
        q[part.rows], points[part.rows] = mended.q[part.rows], mended.points[part.rows]
        return data.changed(q=q, points=points)

    what, mend = f"at {part.where} {one.what}", f"there: {one.mend}"
    return replace(one, what=what, mend=mend, undo=undo, frame=False)


def _placed(data: Sample, some: NDArray[np.int64], rounds: int = 40) -> Placed:
    """The set-up as some of its poses place it."""
    here = np.zeros(len(data.rows), bool)
    here[some] = True
    seen = sight(data.where, data.points, data.on, here)
    return place(seen, data.stated, held(data), turns=False, rounds=rounds)


def _off(data: Sample, placed: Placed) -> Array:
    """(N,) [m] how far the farthest point of each pose is from where a placed robot has it; NaN: not seen."""
    robot = data.where.points(placed.targets, data.on)
    off = np.linalg.norm(data.points - placed.t - robot @ placed.R.T, axis=2)
    seen = np.isfinite(off)
    return np.where(seen.any(axis=1), np.where(seen, off, 0.0).max(axis=1), np.nan)


def _spread(data: Sample, placed: Placed) -> float:
    """[m] of the points of the robot or of those measured, whichever spread less: wrong joints or a moved
    instrument only spread them."""
    seen = data.points[np.isfinite(data.points).all(axis=2)]
    both = (seen, data.where.points(placed.targets, data.on).reshape(-1, 3))
    return min(spread_of(points) for points in both) + 1e-9
