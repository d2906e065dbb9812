"""How far bounds from a fit's covariance have to be stretched to hold on poses that it did not see."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...robot.kinematics import Array
from .bound import LEVEL, length_bound
from .left_out import Leaver, LeftOut, joined

WILD = 0.99  # quantile of the squared errors above which they do not count in a mean
MOST_GROWTH = 20.0


@dataclass(frozen=True)
class Tempering:
    """inflation: factor on the covariance of the fitted numbers; rest: [m] one sigma per axis of what is left
    unknown; factor: on the bounds; growth: of the bounds outside, as in `LeftOut.beyond`."""

    inflation: float
    rest: float
    factor: float
    growth: float

    def covariance(self, fitted: Array, scatter: Array) -> Array:
        """(..., 3, 3) [m²] of the tool's place: by the fitted numbers, the joints' repeatability, the rest."""
        return self.inflation * fitted + scatter + self.rest**2 * np.eye(3)

    def bound(self, fitted: Array, other: Array, beyond: Array, mean: Array | None = None) -> Array:
        """(...) [m] 95 % bound of the length; other: (..., 3, 3) scatter, and the instrument if it is asked
        for; beyond: (...) how far outside; mean: (..., 3) of the error itself."""
        stretch = self.factor * (1 + self.growth * beyond)
        covariance = self.covariance(fitted, other) * stretch[..., None, None] ** 2
        return length_bound(covariance, mean)


def temper(leaver: Leaver, instrument_known: bool) -> Tempering:
    """From held-out errors. The factor is the conformal quantile of error over bound (Vovk 2005, Lei 2018:
    it holds for a further pose whatever the errors' distribution); the growth is that of the poses at the
    ends of the joints' ranges, predicted from all others."""
    out = leaver.by_position()
    squared = (out.error**2).sum(axis=1)
    usual = squared <= np.quantile(squared, WILD)
    expected = _trace(out.fitted + out.scatter + out.seen)[usual].mean()
    ratio = float(squared[usual].mean() / expected)
    inflation = max(ratio, 1.0) if instrument_known else ratio
    other = out.scatter + out.seen * instrument_known
    left = (squared - _trace(inflation * out.fitted + other))[usual].mean() / 3
    plain = Tempering(inflation, float(np.sqrt(max(left, 0.0))), 1.0, 0.0)
    stretch = np.sort(np.sqrt(squared) / plain.bound(out.fitted, other, out.beyond))
    rank = int(np.ceil((len(stretch) + 1) * LEVEL)) - 1
    factor = float(stretch[min(rank, len(stretch) - 1)])
    held = Tempering(inflation, plain.rest, factor, 0.0)
    return Tempering(inflation, plain.rest, factor, _growth(held, list(leaver.by_end()), instrument_known))


def _growth(inside: Tempering, ends: list[LeftOut], instrument_known: bool) -> float:
    """The least growth with which the bounds hold at the ends of the joints' ranges."""
    if not ends:
        return 0.0
    out = joined(ends)
    bound = inside.bound(out.fitted, out.scatter + out.seen * instrument_known, np.zeros(len(out.error)))
    need = np.linalg.norm(out.error, axis=1) / bound - 1
    growth = need[need > 0] / np.maximum(out.beyond[need > 0], 1e-9)
    spare = int((1 - LEVEL) * len(need))
    largest = np.sort(growth)[::-1]
    return float(min(largest[spare], MOST_GROWTH)) if len(largest) > spare else 0.0


def _trace(covariance: Array) -> Array:
    return np.asarray(np.trace(covariance, axis1=-2, axis2=-1))
