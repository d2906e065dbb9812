"""Derivatives of a campaign's rows by the fitted numbers: those of errors of joints kept as amounts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..robot.kinematics import Array
from .patterns import Index, Pattern, Sums


@dataclass(frozen=True, eq=False)
class Jacobian:
    """J (N, D, P). patterns: its columns, of those without a motion first; at: which of the P numbers are
    whose."""

    patterns: Sequence[Pattern]
    at: Sequence[Index]

    @cached_property
    def columns(self) -> Array:
        """(N, D, P) written out."""
        plain = self.patterns[0].amount
        out = np.empty((*plain.shape[:2], sum(len(own) for own in self.at)))
        for pattern, own in zip(self.patterns, self.at, strict=True):
            out[:, :, own] = pattern.columns
        return out

    @property
    def rows(self) -> Array:
        """(N D, P) the same, one below the other."""
        return self.columns.reshape(-1, self.columns.shape[2])

    def some(self, poses: Index) -> Jacobian:
        """Of some poses."""
        return Jacobian([pattern.some(poses) for pattern in self.patterns], self.at)

    def times(self, change: Array) -> Array:
        """(N, D) J x for a change x (P,)."""
        parts = [change[own] for own in self.at]
        return np.sum([p.times(x) for p, x in zip(self.patterns, parts, strict=True)], axis=0)

    def onto(self, r: Array) -> Array:
        """(P,) Jᵀ r of rows (N, D)."""
        out = np.empty(sum(len(own) for own in self.at))
        for pattern, own in zip(self.patterns, self.at, strict=True):
            out[own] = pattern.onto(r)
        return out

    def squares(self, r: Array) -> tuple[Array, Array]:
        """(P, P) Jᵀ J and (P,) Jᵀ r of rows (N, D)."""
        place = np.argsort(np.concatenate(self.at))
        total = Sums(len(place), 0)
        total.add(self.patterns, np.zeros((*r.shape, 0)), r)
        return total.GG[np.ix_(place, place)], total.Ge[place]
