"""What happened to one quantity over all occasions: the levels that its events together give it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from ...robot.kinematics import Array
from .beside import how_sure
from .candidates import Shape
from .decision import Decided
from .found import BACK, CREEP, LEVELS, STEP

NOTHING = 3e-3  # probability by chance from which a level is none


@dataclass(frozen=True, eq=False)
class Levels:
    """A quantity that some members (by their numbers) change. mean: (K, g), half: (K, g, ·) with half halfᵀ
    the covariance, each against the first occasion in prior sizes of `shape`; there: (K,) it is off there;
    all_numbers: (n + g, ·) half of the covariance of all that is solved for, in the same draws."""

    members: tuple[int, ...]
    shape: Shape
    mean: Array
    half: Array
    there: Array
    all_numbers: Array

    @property
    def furthest(self) -> int:
        """The first occasion where it is off by most."""
        size = np.linalg.norm(self.mean[:, : self.shape.main], axis=1)
        return int(np.argmax(size > (1 - 1e-9) * size.max()))

    @property
    def places(self) -> NDArray[np.int64]:
        """Where it is off; where that is nowhere by more than chance, the occasion where it is off most."""
        return np.flatnonzero(self.there) if self.there.any() else np.array([self.furthest])

    @property
    def course(self) -> str:
        """Stepped once, was off and is back, crept evenly to the last, or what no such word says."""
        if not self.there[-1]:
            return BACK
        if len(self.members) > 1 or self.shape.courses > 1:
            return LEVELS
        return STEP if set(self.shape.pattern.flat) == {0.0, 1.0} else CREEP

    def at(self, k: int) -> tuple[Array, Array]:
        """Mean and covariance at an occasion."""
        return self.mean[k], self.half[k] @ self.half[k].T


def levels_of(decided: Decided, members: Sequence[int]) -> Levels:
    """Of members that change the same numbers."""
    shapes = [decided.shape(decided.members[i]) for i in members]
    solved, n = decided.solved, decided.solved.background
    rows = [slice(n + decided.part(i).start, n + decided.part(i).stop) for i in members]
    own = list(zip(shapes, rows, strict=True))
    mean = np.sum([shape.levels(solved.values[at]) for shape, at in own], axis=0)
    every = how_sure(decided, members)
    half = np.sum([shape.levels(decided.factor(shape.pattern) * every[at]) for shape, at in own], axis=0)
    some = np.any([shape.pattern.any(axis=1) for shape in shapes], axis=0)
    if len(members) > 1 or shapes[0].courses > 1:
        some &= [_off(m, h, shapes[0].main) for m, h in zip(mean, half, strict=True)]
    return Levels(tuple(members), shapes[0], mean, half, some, every)


def _off(mean: Array, half: Array, main: int) -> bool:
    """Whether a level is none by more than chance."""
    if not half[:main].any():
        return False
    covariance = half[:main] @ half[:main].T
    return bool(mean[:main] @ np.linalg.solve(covariance, mean[:main]) > chi2.isf(NOTHING, main))


def together(decided: Decided, members: Sequence[int]) -> Iterator[list[int]]:
    """Members that change the same numbers of one quantity, in the order of the first of each."""
    found: list[list[int]] = []
    for i in members:
        same = next((own for own in found if _same(decided, i, own[0])), None)
        if same is None:
            found.append([i])
        else:
            same.append(i)
    yield from found


def _same(decided: Decided, i: int, j: int) -> bool:
    one, other = decided.members[i], decided.members[j]
    if decided.candidates[one.component].quantity != decided.candidates[other.component].quantity:
        return False
    return decided.shape(one).base is decided.shape(other).base
