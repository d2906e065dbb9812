"""Patterns in the data: whitened columns of effects, and their scalar products.

What errs in a joint moves the points of a pose along one motion, that of the joint, by an amount that depends
on the pose. Products of such columns need the amounts alone: one number per pose, not one per coordinate.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise

import numpy as np
from numpy.typing import NDArray

from ..robot.kinematics import Array

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

    def some(self, poses: Index) -> Pattern:
        """At some poses."""
        motion = None if self.motion is None else self.motion[poses]
        return replace(self, amount=self.amount[poses], motion=motion)

    def times(self, change: Array) -> Array:
        """(N, D) what a change (p,) of its numbers makes of the rows."""
        amount = self.amount @ change
        return np.asarray(amount if self.motion is None else self.motion * amount[:, None])

    def onto(self, r: Array) -> Array:
        """(p,) products of its columns with rows (N, D)."""
        along = r if self.motion is None else (self.motion * r).sum(axis=1)
        return np.asarray(along.ravel() @ self.amount.reshape(along.size, -1))

    def most(self, sizes: Array) -> float:
        """The largest number of its columns in these sizes."""
        largest = np.abs(self.amount * sizes)
        if self.motion is not None:
            largest = largest * np.abs(self.motion).max(axis=1)[:, None]
        return float(largest.max(initial=0.0))


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
    total = Sums(sum(pattern.amount.shape[-1] for pattern in patterns), J.shape[2])
    for at in range(0, len(poses), BLOCK):
        here = slice(at, at + BLOCK)
        total.add([_together(own, poses[here]) for own in groups], J[here], e[here])
    return Products(total.GG, total.JG, total.Ge)


class Sums:
    """Products of columns of which those along one motion stand together, summed over blocks of poses."""

    def __init__(self, columns: int, background: int) -> None:
        self.GG = np.zeros((columns, columns))
        self.JG = np.zeros((background, columns))
        self.Ge = np.zeros(columns)

    def add(self, groups: Sequence[Pattern], J: Array, e: Array) -> None:
        """groups: one pattern for each motion, and before them those without one."""
        moving = [group for group in groups if group.motion is not None]
        own = groups[0].amount if len(moving) < len(groups) else np.zeros((*e.shape, 0))
        h = own.shape[2]
        self.GG[:h, :h] += _flat(own).T @ _flat(own)
        self.JG[:, :h] += _flat(J).T @ _flat(own)
        self.Ge[:h] += e.ravel() @ _flat(own)
        if not moving:
            return
        motions = np.stack([group.motion for group in moving if group.motion is not None], axis=1)
        weights = np.matmul(motions, motions.swapaxes(1, 2))
        with_own, with_J = np.matmul(motions, own), np.matmul(motions, J)
        with_e = np.matmul(motions, e[:, :, None])
        first, done = h, list[tuple[slice, Array]]()
        for i, amount in enumerate(group.amount for group in moving):
            part = slice(first, first := first + amount.shape[1])
            products = amount.T @ with_own[:, i]
            self.GG[part, :h] += products
            self.GG[:h, part] += products.T
            self.JG[:, part] += with_J[:, i].T @ amount
            self.Ge[part] += with_e[:, i, 0] @ amount
            for k, (other, before) in enumerate(done):
                both = amount.T @ (before * weights[:, i, k, None])
                self.GG[part, other] += both
                self.GG[other, part] += both.T
            scaled = amount * np.sqrt(weights[:, i, i, None])
            self.GG[part, part] += scaled.T @ scaled
            done.append((part, amount))


def _together(patterns: Sequence[Pattern], poses: Index) -> Pattern:
    """Patterns along one motion, or without any, side by side, at some poses."""
    first = patterns[0]
    amount = np.concatenate([pattern.amount[poses] for pattern in patterns], axis=-1)
    return Pattern(amount, None if first.motion is None else first.motion[poses], first.joint)


def _flat(X: Array) -> Array:
    return X.reshape(X.shape[0] * X.shape[1], X.shape[2])
