"""What is printed, boiled down to the numbers that accounts are judged by: the same for the print and a
draw."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench import Array

BLOCKS = [1, 2, 4], [0, 3, 5]  # joints that turn in the arm's plane, and across it
STILL = 1e-9  # ln K that scatters by less has not moved


def summary(K: Mapping[str, Array], errors: Mapping[str, tuple[float, float]]) -> dict[str, Array]:
    """Item name → numbers. K: (C, n) [N·m/rad] of `theory`, `constant`, `2` and `16`; errors: mean and
    largest [mm] of `raw`, `theory` and each cut (NaN where none is printed)."""
    mean = {key: value[0] for key, value in errors.items()}
    worst = {key: value[1] / value[0] for key, value in errors.items()}
    ln = {key: np.log(np.abs(value)) for key, value in K.items()}
    few = np.vstack([ln["theory"], ln["constant"], ln["2"]])
    table = ln["16"]
    return {
        "raw": np.array([mean["raw"]]),
        "left": np.array([mean["constant"] / mean["raw"]]),
        "gains": np.array([mean[key] / mean["constant"] for key in ("2", "16", "128")]),
        "largest": np.array([worst[key] for key in ("raw", "constant", "128")]),
        "kinematics": np.array([mean["theory"] / mean["constant"]]),
        "constant": np.abs(K["constant"][0]),
        "step": np.array([np.sqrt(((few[1] - few[0])[1:5] ** 2).mean())]),
        "halves": np.abs(few[2] - few[3])[[1, 2, 4]],
        "agree": np.array([few[:, 0].std(ddof=1)]),
        "scatter": np.array([np.sqrt(table[:, some].var(axis=0, ddof=1).mean()) for some in BLOCKS]),
        "together": np.array([related(table[:, 1], table[:, 2]), related(table[:, 0], table[:, 3])]),
        "ordered": np.array([np.mean([ordered(table[:, j]) for j in some]) for some in BLOCKS]),
        "signs": np.array([float((K["16"] < 0).sum())]),
    }


def related(a: Array, b: Array) -> float:
    """Correlation of two columns, 0 where one of them stands still."""
    return float(np.corrcoef(a, b)[0, 1]) if min(np.std(a), np.std(b)) > STILL else 0.0


def ordered(column: Array) -> float:
    """Share of the variance of 16 cells that goes with the place along the long side, or with the place
    across it, whichever is larger; by chance a fifth. column: (16,), in a table of four by four."""
    if np.std(column) < STILL:
        return 0.0
    table = column.reshape(4, 4) - column.mean()
    both = [4 * (table.mean(axis=axis) ** 2).sum() for axis in (0, 1)]
    return float(max(both) / (table**2).sum())


def equal(K: Array) -> int:
    """Cells of (C, 6) in which K4 and K6 agree in the three digits that are printed."""
    digits = [[f"{k:.2e}" for k in K[:, j]] for j in (3, 5)]
    return sum(a == b for a, b in zip(*digits, strict=True))
