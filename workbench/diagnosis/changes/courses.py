"""The courses that a number may take over the occasions: it steps and stays, it comes and goes, it creeps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...robot.kinematics import Array

FEW = 2  # columns of what may come and go over any number of occasions: of more columns, over one alone


def courses(first: int, count: int, columns: int, free: bool = False) -> Iterator[Array]:
    """(count,) each: at each of `count` occasions, the share that it has of an event just before the `first`.

    A step that stays, one that is undone, and creeping that begins there. A number may have an event before
    each occasion, so that any course is there, and pays for each. columns: of the number's shape; free: they
    are a free function, which only steps: there are many of them, and no gear heals."""
    number, last = np.arange(count), count - 1
    after = number >= first
    yield after.astype(np.float64)
    if free:
        return
    for end in range(first + 1, (last if columns <= FEW else min(first + 1, last)) + 1):
        yield (after & (number < end)).astype(np.float64)
    if first < last:
        yield np.maximum(number - first + 1, 0) / (last - first + 1)


def any_course(count: int) -> Array:
    """(count, count - 1) a level of its own at each occasion behind the first."""
    return np.eye(count)[:, 1:]
