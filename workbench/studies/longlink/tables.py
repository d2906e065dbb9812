"""What Tables II and III explain by themselves: their difference at the tip, and which entries make it."""

from __future__ import annotations

import numpy as np

from workbench import Array
from workbench import denavit_hartenberg as dh

from .arm import ARM
from .figures import Chapter, entries_table, tables_figure
from .linear import FLOOR, RANGES
from .printed import BEFORE, JUDGED, TABLE_2, TABLE_3

POSES = {
    **{str(limit): (limit, -np.inf) for limit in RANGES},
    **{f"floor_{limit}": (limit, FLOOR) for limit in RANGES},
}
"""[°, m] ± range of the joints and lowest z of the poses that count."""


def two_tables(seed: int, count: int) -> Chapter:
    """What Table III changes against Table II at the tip, in so many random poses."""
    numbers = {"draws": float(count)}
    for name, (limit, lowest) in POSES.items():
        q = ARM.poses(count, seed, limit)
        where = dh.chain(TABLE_2, q)[:, :, :3, 3]
        error = 1e3 * (dh.chain(TABLE_3, q)[:, -1, :3, 3] - where[:, -1])
        kept = where[:, 3:, 2].min(axis=1) > lowest
        size = np.linalg.norm(error[kept], axis=1)
        scatter = float(size.std() / np.sqrt(JUDGED))
        low, high = np.quantile(size, (0.05, 0.95))
        numbers |= {f"mean_{name}_mm": size.mean(), f"low_{name}_mm": low, f"high_{name}_mm": high}
        numbers |= {f"scatter_{name}_mm": scatter, f"away_{name}": (BEFORE - size.mean()) / scatter}
        numbers[f"above_{name}"] = float(len(size) / count)
        numbers[f"z_{name}"] = z_largest(error[kept])
    numbers["ranges"] = float(len(POSES))
    numbers["ranges_near"] = float(sum(abs(numbers[f"away_{name}"]) < 2 for name in POSES))

    q = ARM.poses(count, seed)
    whole = moved(TABLE_3, q)
    sizes, shares, without = by_entry(whole, q)
    size = np.linalg.norm(whole, axis=1)
    numbers |= {
        "without_alpha_1_mm": without["α₁"],
        "share_alpha_1": shares["α₁"],
        "share_lengths": sum(share for name, share in shares.items() if name[0] in "ad"),
    }
    return Chapter(numbers, {"tables": tables_figure(size, BEFORE), "entries": entries_table(sizes, shares)})


def moved(table: Array, q: Array) -> Array:
    """(N, 3) [mm] the tip by a table minus the tip by Table II, for joints q: (N, 7)."""
    return np.asarray(1e3 * (dh.chain(table, q)[:, -1, :3, 3] - dh.chain(TABLE_2, q)[:, -1, :3, 3]))


def by_entry(whole: Array, q: Array) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    """By entry of Table III: mean motion [mm] that it makes alone, its share of the whole (N, 3) [mm], and
    the mean [mm] of what is left without it."""
    sizes, shares, without = {}, {}, {}
    for row, column in np.ndindex(TABLE_2.shape):
        table = TABLE_2.copy()
        table[row, column] = TABLE_3[row, column]
        name, alone = f"{'θαad'[column]}{'₁₂₃₄₅₆₇'[row]}", moved(table, q)
        sizes[name] = float(np.linalg.norm(alone, axis=1).mean())
        shares[name] = float((alone * whole).sum() / (whole**2).sum())
        without[name] = float(np.linalg.norm(whole - alone, axis=1).mean())
    return sizes, shares, without


def z_largest(error: Array) -> float:
    """How often the mean |z| of as many errors (N, 3) as the paper judges by is the largest of the three."""
    means = np.abs(error[: len(error) // JUDGED * JUDGED].reshape(-1, JUDGED, 3)).mean(axis=1)
    return float(np.mean(means.argmax(axis=1) == 2))
