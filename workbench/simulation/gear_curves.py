"""Errors and torques of the joints, taken apart into curves over one joint each: for loop and exports."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..robot.kinematics import Array

SAMPLES = 2001  # of a curve, at least
PER_PERIOD = 60  # samples, of an error with an order: the cubic between them is right to 3e-7 of it


def curves(
    values: Callable[[Array], Array], start: Array, low: Array, high: Array, order: float
) -> tuple[Array, dict[tuple[int, int], Array]]:
    """What `values` (M, n) of joints (M, n) is at `start` (n,), and how it changes with one joint at a time.

    The latter as (joint, joint that it depends on) → (2, M): positions of that one between low (n,) and high
    (n,), and the change. order: the most periods per turn.
    """
    rest, out = values(start[None])[0], {}
    for k in range(len(start)):
        count = max(SAMPLES, int(PER_PERIOD * order * (high[k] - low[k]) / (2 * np.pi)))
        q = np.tile(start, (count, 1))
        q[:, k] = np.linspace(low[k], high[k], count)
        change = values(q) - rest
        for j in np.flatnonzero(np.ptp(change, axis=0) > 0).tolist():
            out[j, k] = np.stack([q[:, k], change[:, j]])
    return rest, out
