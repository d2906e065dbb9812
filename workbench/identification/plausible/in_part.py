"""Mistakes of a part of a campaign: its first or its last poses fit the robot, the others do not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...campaign.problem import Problem
from .hypotheses import Hypothesis
from .misfit import Sample, misfit

FEWEST = 8  # poses of each part
WIDE = 0.5  # of the spread of all points at least: what hardly moves fits any robot


def not_fitting(data: Sample, spread: float, fits: float) -> NDArray[np.int64] | None:
    """Which poses of a sample of one set-up do not fit, where those before or those after them leave no more
    than `fits`. spread: of all points [m]."""
    count = len(data.rows)
    if len(np.unique(data.setup)) > 1:
        return None
    for order in (np.arange(count), np.arange(count)[::-1]):
        most, too_many = FEWEST - 1, count  # poses from that end that fit, and that do not
        while too_many - most > 1:
            middle = (most + too_many) // 2
            if misfit(_only(data, np.sort(order[:middle]))).total <= fits:
                most = middle
            else:
                too_many = middle
        enough = FEWEST <= most <= count - FEWEST
        if enough and misfit(_only(data, np.sort(order[:most]))).spread >= WIDE * spread:
            return np.sort(order[most:])
    return None


def in_part(
    problem: Problem, data: Sample, part: NDArray[np.int64], every: Iterable[Hypothesis]
) -> Iterator[Hypothesis]:
    """That the instrument or the tool stands elsewhere there, or another mistake was made there alone."""
    where = named(problem, data, part)
    what = f"the instrument or the tool stands elsewhere at {where}"
    mend = "give these poses a name of their own in a column setup"

    def apart(sample: Sample) -> Sample:
        setup = sample.setup.copy()
        setup[part] += 1
        return sample.changed(setup=setup, stated=np.full_like(sample.stated, np.nan))

    yield Hypothesis("poses", what, mend, apart)
    for one in every:
        if one.table in ("poses", "points"):
            yield _there(one, part, where)


def _there(one: Hypothesis, part: NDArray[np.int64], where: str) -> Hypothesis:
    """The mistake at a part of the poses."""

    def undo(data: Sample) -> Sample:
        mended, q, points = one.undo(data), data.q.copy(), data.points.copy()
        q[part], points[part] = mended.q[part], mended.points[part]
        return data.changed(q=q, points=points)

    return replace(one, what=f"at {where} {one.what}", mend=f"there: {one.mend}", undo=undo, frame=False)


def named(problem: Problem, data: Sample, part: NDArray[np.int64]) -> str:
    """The part by its first and last pose."""
    ids = problem.campaign.poses.ids
    first, last = (ids[data.rows[i]] for i in (part[0], part[-1]))
    return f"the poses {first} … {last}"


def _only(data: Sample, part: NDArray[np.int64]) -> Sample:
    return data.changed(
        rows=data.rows[part], q=data.q[part], points=data.points[part], setup=data.setup[part]
    )
