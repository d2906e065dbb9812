"""Height of a drawn path over its plane: the R_a and R_z of Olabi et al. (2012), and what they depend on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench import Array, Figure, charts


def heights(wanted: Array, error: Array, zero: float, noise: Array) -> dict[str, float]:
    """R_a and R_z in mm of a path wanted (N, 3) and its error (N, 3) [m].

    ra, rz: mean of |z − zero|, and highest minus lowest z; *_seen: with an instrument's noise (N,) [m]
    on each reading; ra_base: from the plane itself, ra_own: from the path's own mean; rz_level: from the
    plane that fits best.
    """
    z, at, seen = 1e3 * error[:, 2], 1e3 * zero, 1e3 * (error[:, 2] + noise)
    flat = np.column_stack([wanted[:, :2], np.ones(len(z))])
    found = {
        "ra": np.abs(z - at).mean(),
        "rz": np.ptp(z),
        "ra_seen": np.abs(seen - at).mean(),
        "rz_seen": np.ptp(seen),
        "ra_base": np.abs(z).mean(),
        "ra_own": np.abs(z - z.mean()).mean(),
        "rz_level": np.ptp(z - flat @ np.linalg.lstsq(flat, z)[0]),
    }
    return {key: float(value) for key, value in found.items()}


def least_mean(ra: float, rz: float) -> float:
    """The least mean height that a profile with this R_a and R_z can have, for one that is nearly one-sided.

    It has two heights, −a and rz − a, and as much weight on the lower as R_a allows; a makes it least.
    """
    a = np.linspace(0.0, min(rz - ra, rz / 2), 1001)[:-1]
    low = np.clip((rz - a - ra) / (rz - 2 * a), 0.0, 1.0)
    return float((ra - 2 * low * a).min())


def height_figure(name: str, title: str, time: Array, error: Mapping[str, Array], zero: float) -> Figure:
    """Height over `zero` [m] along a path, per command: error (N, 3) [m] at times (N,) [s]."""
    z = {key: 1e3 * (e[:, 2] - zero) for key, e in error.items()}
    series = {
        key: charts.Series(values, colour=colour)
        for (key, values), colour in zip(z.items(), charts.COLOURS[1::-1] + charts.COLOURS[2:], strict=False)
    }
    x, y = "time along the path, s", "height over the plane, mm"
    return charts.curves(name, title, time - time[0], series, x, y)
