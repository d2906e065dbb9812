"""How many cells noise allows: what finer cells remove of the model's error, and what they add by noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arm import Array


@dataclass(frozen=True, eq=False)
class Trade:
    """Mean squared errors [m²] of models with more and more cells, all fitted to the same measurements.

    counts: (K,) numbers of cells, rising; bias: (K,) what each leaves without noise; variance: (K,) what
    noise adds.
    """

    counts: Array
    bias: Array
    variance: Array

    @property
    def best(self) -> int:
        """The number of cells with the least error: with more of them noise adds more than they remove."""
        return int(self.counts[(self.bias + self.variance).argmin()])

    def scaled(self, share: float) -> Trade:
        """The same where the missing effect is only so large."""
        return Trade(self.counts, share**2 * self.bias, self.variance)

    @property
    def pays(self) -> float:
        """Share of the missing effect from which the most cells are better than the fewest."""
        removed, added = self.bias[0] - self.bias[-1], self.variance[-1] - self.variance[0]
        return float(np.sqrt(max(added, 0.0) / removed)) if removed > 0 else np.inf


def trade(
    counts: Sequence[int], true: Array, clean: Sequence[Array], noisy: Sequence[Sequence[Array]]
) -> Trade:
    """From deflections (M, 3) [m]: the true ones, and each model's from data without noise (K) and with it
    (draws, K)."""
    bias = [float(((one - true) ** 2).sum(axis=1).mean()) for one in clean]
    spread = [[((one - clean[k]) ** 2).sum(axis=1).mean() for k, one in enumerate(draw)] for draw in noisy]
    return Trade(np.array(counts, dtype=float), np.array(bias), np.mean(spread, axis=0))
