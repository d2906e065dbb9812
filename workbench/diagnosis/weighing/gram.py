"""Scalar products of columns with each other: of some thousand columns stored, of more worked out from their
rows where they are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from scipy.sparse import csc_array

from ...identification.patterns import Index
from ...robot.kinematics import Array


class Gram(Protocol):
    """S (g, g)."""

    def __len__(self) -> int: ...

    def between(self, rows: Index, columns: Index) -> Array:
        """(..., c) of numbers of rows (...) with columns (c,)."""

    def blocks(self, index: Index) -> Array:
        """(F, p, p) of columns (F, p), each F of one form, among themselves."""

    def combined(self, v: csc_array, columns: Index) -> tuple[Array, Array]:
        """(m, m) of m combinations v (g, m) of few columns each, and (m, c) with columns (c,)."""

    def times(self, factor: float) -> Gram:
        """All of them times a factor."""


class Stored:
    """All of them: of columns (g,) that are multiples `size` (g,) of fewer, number `of` (g,) of those whose
    products S (m, m) are."""

    def __init__(self, S: Array, of: Index | None = None, size: Array | None = None) -> None:
        self.S = S
        self.of = np.arange(len(S)) if of is None else of
        self.size = np.ones(len(self.of)) if size is None else size

    def __len__(self) -> int:
        return len(self.of)

    def between(self, rows: Index, columns: Index) -> Array:
        return self._taken(rows[..., None], columns)

    def blocks(self, index: Index) -> Array:
        return self._taken(index[:, :, None], index[:, None])

    def _taken(self, rows: Index, columns: Index) -> Array:
        found = self.S.take(self.of[rows] * len(self.S) + self.of[columns])
        found *= self.size[rows]
        found *= self.size[columns]
        return found

    def combined(self, v: csc_array, columns: Index) -> tuple[Array, Array]:
        rows, shape = v.indices, (len(self.S), v.shape[1])
        v = csc_array((v.data * self.size[rows], self.of[rows], v.indptr), shape)
        half = v.T @ self.S
        return np.asarray((v.T @ half.T).T), half[:, self.of[columns]] * self.size[columns]

    def times(self, factor: float) -> Stored:
        return Stored(factor * self.S, self.of, self.size)


class OfRows:
    """Of columns with few rows, W (g, R): S = W Wᵀ. widths: of forms whose columns stand side by side; their
    own products are kept, as are those of every column that was once asked for."""

    def __init__(self, W: Array, widths: Sequence[int]) -> None:
        self.W, self.widths = W, tuple(widths)
        self._place = dict[int, int]()
        self._kept = np.empty((len(W), 0))
        self._beside = np.zeros((len(W), max(self.widths, default=0)))
        at = 0
        for width in self.widths:
            own = W[at : at + width] @ W[at : at + width].T
            for i in range(width):
                self._beside[at + i, : width - i] = own[i, i:]
            at += width

    def __len__(self) -> int:
        return len(self.W)

    def between(self, rows: Index, columns: Index) -> Array:
        if rows.size <= len(self.widths):  # few: not worth a column of all
            return np.asarray((self.W[rows.ravel()] @ self.W[columns].T).reshape(*rows.shape, len(columns)))
        new = [c for c in dict.fromkeys(columns.tolist()) if c not in self._place]
        if new:
            self._place |= {c: len(self._place) + i for i, c in enumerate(new)}
            self._kept = np.concatenate([self._kept, self.W @ self.W[new].T], axis=1)
        places = np.array([self._place[c] for c in columns.tolist()], dtype=np.int64)
        return np.asarray(self._kept[rows[..., None], places])

    def blocks(self, index: Index) -> Array:
        first = np.minimum(index[:, :, None], index[:, None, :])
        return np.asarray(self._beside[first, np.abs(index[:, :, None] - index[:, None, :])])

    def combined(self, v: csc_array, columns: Index) -> tuple[Array, Array]:
        half = v.T @ self.W
        return half @ half.T, half @ self.W[columns].T

    def times(self, factor: float) -> OfRows:
        return OfRows(np.sqrt(factor) * self.W, self.widths)
