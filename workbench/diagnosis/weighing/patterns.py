"""Patterns in the data: whitened columns of effects, and their scalar products.

What errs in a joint moves the points of a pose along one motion, that of the joint, by an amount that depends
on the pose. Products of such columns need the amounts alone: one number per pose, not one per coordinate.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np
from numpy.typing import NDArray

from ...effects.base import Effect
from ...identification.fit import Fit
from ...robot.kinematics import Array

Index = NDArray[np.int64]
BLOCK = 400  # poses whose columns stand side by side at once


@dataclass(frozen=True, eq=False)
class Pattern:
    """Columns of an effect. amount: (N, p) by how much a pose's points go along the motion of joint number
    `joint`, motion: (N, D); or, without a motion, the columns (N, D, p) themselves."""

    amount: Array
    motion: Array | None = None
    joint: int = -1

    @property
    def columns(self) -> Array:
        """(N, D, p)."""
        if self.motion is None:
            return self.amount
        return np.asarray(self.motion[:, :, None] * self.amount[:, None, :])

    def most(self, sizes: Array) -> float:
        """The largest number of its columns in these sizes."""
        largest = np.abs(self.amount * sizes)
        if self.motion is not None:
            largest = largest * np.abs(self.motion).max(axis=1)[:, None]
        return float(largest.max(initial=0.0))


def pattern_of(fit: Fit, effect: Effect) -> Pattern:
    """The whitened columns of an effect at zero, in the model or not."""
    own = effect.of_joint(fit.model.problem)
    if own is None:
        return Pattern(fit.whitened(effect))
    joint, amount = own
    return Pattern(amount, fit.axial[:, :, joint], joint)


@dataclass(frozen=True)
class Products:
    """Scalar products of columns G (R, g). GG: (g, g) with each other; JG: (n, g) with columns J of a
    background; Ge: (g,) with the data."""

    GG: Array
    JG: Array
    Ge: Array

    @classmethod
    def of(cls, J: Array, G: Array, e: Array) -> Products:
        return cls(G.T @ G, J.T @ G, G.T @ e)


def once(sized: Iterable[tuple[Pattern, Array]]) -> tuple[list[Pattern], Index, Array]:
    """Patterns without repetition, those along one motion together, and of the columns of all their numbers
    (g,) among those of these, with the sizes (g,) that they stand there in."""
    every = list(sized)
    own = sorted({id(pattern): pattern for pattern, _ in every}.values(), key=lambda pattern: pattern.joint)
    ends = np.cumsum([0, *(pattern.amount.shape[-1] for pattern in own)])
    columns = {id(pattern): np.arange(a, b) for pattern, (a, b) in zip(own, pairwise(ends), strict=True)}
    of = np.concatenate([np.zeros(0, int), *(columns[id(pattern)] for pattern, _ in every)])
    return own, of, np.concatenate([np.zeros(0), *(sizes for _, sizes in every)])


def products_of(patterns: Sequence[Pattern], J: Array, e: Array, poses: Index) -> Products:
    """Products of the columns of patterns, those along one motion together, with J (M, D, n) and e (M, D) of
    these poses (M,); a block of poses at a time: the columns never stand side by side for all."""
    groups = [list(own) for _, own in groupby(patterns, key=lambda pattern: pattern.joint)]
    total = _Sums(sum(pattern.amount.shape[-1] for pattern in patterns), J.shape[2])
    for at in range(0, len(poses), BLOCK):
        here = slice(at, at + BLOCK)
        total.add([_together(own, poses[here]) for own in groups], J[here], e[here])
    return Products(total.GG, total.JG, total.Ge)


class _Sums:
    """Products of columns of which those along one motion stand together, summed over blocks of poses."""

    def __init__(self, columns: int, background: int) -> None:
        self.GG = np.zeros((columns, columns))
        self.JG = np.zeros((background, columns))
        self.Ge = np.zeros(columns)

    def add(self, groups: Sequence[Pattern], J: Array, e: Array) -> None:
        """groups: one pattern for each motion, and before them those without one."""
        moving = [group for group in groups if group.motion is not None]
        own = groups[0].amount if len(moving) < len(groups) else np.zeros((*e.shape, 0))
        beside = np.concatenate([own, J, e[:, :, None]], axis=2)
        h, n = own.shape[2], J.shape[2]
        self.GG[:h, :h] += _flat(own).T @ _flat(own)
        with_others = _flat(own).T @ _flat(beside[:, :, h:])
        self.JG[:, :h] += with_others[:, :n].T
        self.Ge[:h] += with_others[:, n]
        first, done = h, list[tuple[slice, Pattern]]()
        for group in moving:
            assert group.motion is not None
            part = slice(first, first + group.amount.shape[1])
            along = np.matmul(group.motion[:, None, :], beside)[:, 0]
            products = group.amount.T @ along
            self.GG[part, :h] += products[:, :h]
            self.GG[:h, part] += products[:, :h].T
            self.JG[:, part] += products[:, h : h + n].T
            self.Ge[part] += products[:, h + n]
            for other, before in done:
                assert before.motion is not None
                weight = (group.motion * before.motion).sum(axis=1)
                both = group.amount.T @ (before.amount * weight[:, None])
                self.GG[part, other] += both
                self.GG[other, part] += both.T
            scaled = group.amount * np.sqrt((group.motion**2).sum(axis=1))[:, None]
            self.GG[part, part] += scaled.T @ scaled
            done.append((part, group))
            first = part.stop


def _together(patterns: Sequence[Pattern], poses: Index) -> Pattern:
    """Patterns along one motion, or without any, side by side, at some poses."""
    first = patterns[0]
    amount = np.concatenate([pattern.amount[poses] for pattern in patterns], axis=-1)
    return Pattern(amount, None if first.motion is None else first.motion[poses], first.joint)


def _flat(X: Array) -> Array:
    return X.reshape(X.shape[0] * X.shape[1], X.shape[2])
