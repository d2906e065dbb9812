"""How many cells noise allows: what finer cells remove of the model's error, and what they add by noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench import Array, Campaign, Figure, Table, charts, fit_cells, numbers, simulate

from .loads import Case
from .printed import CUTS
from .protocol import BOX, IN_BASE


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


def how_many(
    case: Case,
    found: Mapping[str, Array],
    check: Campaign,
    draws: int,
    seed: int,
) -> Trade:
    """The trade of cuts that all use all measurements. found: (C, 3) [m] of models fitted already: those of
    128 cells and of one ("same") have used all."""

    def said(data: Campaign, known: Mapping[str, Array]) -> list[Array]:
        fits = {
            key: fit_cells(data, BOX, cut, instrument=IN_BASE)
            for key, cut in CUTS.items()
            if key not in known
        }
        return [known[key] if key in known else fits[key].deflection(check)[len(case.true) :] for key in CUTS]

    noisy = [said(case.data, {"constant": found["same"], "128": found["128"]})]
    for k in range(1, draws):
        noisy.append(said(simulate(case.data, case.truth, seed=seed + 10 * k, instrument=IN_BASE), {}))
    counts = [int(np.prod(cut)) for cut in CUTS.values()]
    return trade(counts, case.true, said(case.clean, {}), noisy)


def allowed_table(missing: Trade) -> Table:
    """How many cells noise allows, for other sizes of the effect that is missing."""
    lines = []
    for share in (1.0, 0.3, 0.1, 0.03, 0.0):
        one = missing.scaled(share)
        best = f"{one.best} or more" if one.best == one.counts[-1] else str(one.best)
        error = 1e3 * np.sqrt(one.bias + one.variance)
        left = numbers.mm(1e3 * np.sqrt(one.bias[0]))
        lines.append([numbers.percent(share, 0), left, *map(numbers.mm, error), best])
    head = ("Of the effect", "Constant leaves", *(f"{int(k)}" for k in missing.counts), "Allowed")
    note = "RMS errors in mm with 1, 2, 16 and 128 cells, noise and what is missing together."
    return Table("How many cells noise allows", head, lines, note)


def count_figure(constant: Trade, missing: Trade) -> Figure:
    """What finer cells remove where something is missing, and what noise adds there and where nothing is."""
    left, added, noise = (1e3 * np.sqrt(x) for x in (missing.bias, missing.variance, constant.variance))
    series = {
        "(b) what the model leaves": charts.Series(left, colour=charts.OURS),
        "(b) what noise adds": charts.Series(added, colour=charts.OURS, style="--"),
        "(a) what noise adds": charts.Series(noise, colour=charts.NOISE, style="--"),
    }
    title = "Finer cells remove some of what is missing in (b), and add noise in both"
    label = "number of cells, as a power of 2 (0: one cell, 7: 128 cells)"
    return charts.curves("count", title, np.log2(missing.counts), series, label, "RMS error, mm", log=True)
