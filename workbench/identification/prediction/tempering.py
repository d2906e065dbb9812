"""How far bounds from a fit's covariance have to be stretched to hold on poses that it did not see."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import chdtr, chdtri, log_ndtr

from ...robot.kinematics import Array
from .bound import LEVEL, length_bound
from .left_out import Leaver, LeftOut, joined

WILD = 0.99  # quantile of the squared errors at which larger ones are cut in a mean
LESS = 0.85  # of the errors that are expected: by less an instrument's noise is as stated
MOST_GROWTH = 20.0
MOST_VARIANCE = 100.0


@dataclass(frozen=True)
class Tempering:
    """rest: [m] one sigma per axis of what is left unknown; factor: on the bounds; growth: of the bounds
    outside, as in `LeftOut.beyond`."""

    rest: float
    factor: float
    growth: float

    def bound(self, fitted: Array, other: Array, beyond: Array, mean: Array | None = None) -> Array:
        """(...) [m] 95 % bound of the length. fitted: (..., 3, 3) [m²] covariance by the fitted numbers;
        other: (..., 3, 3) the joints' repeatability, and the instrument if it is asked for; beyond: (...) how
        far outside; mean: (..., 3) [m] of the error itself."""
        stretch = self.factor * (1 + self.growth * beyond)
        covariance = fitted + other + self.rest**2 * np.eye(3)
        return length_bound(covariance * stretch[..., None, None] ** 2, mean)

    def stretch(self, out: LeftOut, instrument_known: bool) -> float:
        """The conformal quantile of error over bound."""
        bound = self.bound(out.fitted, out.scatter + out.seen * instrument_known, out.beyond)
        ratio = np.sort(np.linalg.norm(out.error, axis=1) / bound)
        rank = int(np.ceil((len(ratio) + 1) * LEVEL))
        return float(ratio[min(rank, len(ratio)) - 1]) if len(ratio) else 0.0


def temper(leaver: Leaver, instrument_known: bool, variance: float | None = None) -> tuple[Tempering, float]:
    """From held-out errors; and their variance over the noise, which the fitted numbers' covariance takes,
    where it is not known already.

    Poses in the midst of others say what is left unknown. What a model lacks goes on from pose to pose, so
    that its numbers are less sure than as many independent errors would make them: by how much, regions of
    joint space say that are predicted from all others, as block cross-validation does (Roberts et al. 2017).
    The bounds so grow with leverage, which joints far from the data have together even where none is alone.
    The factor is the conformal quantile of error over bound (Vovk et al. 2005, Lei et al. 2018: it holds for
    a further pose whatever the errors' distribution); the growth is what the ends of the joints' ranges,
    predicted from all others, ask for beside.

    Errors M of the robot are seen under noise R that is known. A factor f on what is seen is then one of g on
    the robot's part, f² (M + R) = g² M + R: d log f = w d log g with w = M / (M + R), and says the less of g,
    the more noise there is. Above 1 what was measured asks for it; below 1 it is taken as f^w.
    """
    variance = _variance(leaver, instrument_known) if variance is None else variance
    out = leaver.by_position(variance)
    rest = _rest(out, instrument_known)
    both = joined([out, leaver.by_part(variance).inside])
    factor = Tempering(rest, 1.0, 0.0).stretch(both, instrument_known)
    if factor < 1:
        factor **= _robots_share(both, rest, instrument_known)
    growth = _growth(Tempering(rest, factor, 0.0), list(leaver.by_end(variance)), instrument_known)
    return Tempering(rest, factor, growth), variance


def is_overstated(leaver: Leaver) -> bool:
    """Whether poses left out are nearer than the instrument's noise lets expect: then nobody knows how much
    of what is left is the instrument's."""
    out = leaver.by_position(1.0)
    share = _squared(out).mean() / _expected(out, instrument_known=True).mean()
    by_chance = 3 * np.sqrt(2 / (3 * len(out.error)))
    return bool(share < min(LESS, 1 - by_chance))


def _variance(leaver: Leaver, instrument_known: bool) -> float:
    """With which squared errors of regions left out are as large as expected in the mean of all regions; or,
    where even those in the midst of others are smaller than expected, as many times that as they are."""

    def lacking(log: float) -> float:
        variance = float(np.exp(log))
        midst = leaver.by_position(variance)
        rest = _rest(midst, instrument_known)

        def share(out: LeftOut) -> float:
            expected = _expected(out, instrument_known) + 3 * rest**2
            return float(np.mean((out.error**2).sum(axis=1) / expected))

        found = [share(out) for out in leaver.by_region(variance) if len(out.error)]
        return float(np.mean(found)) - min(share(midst), 1.0)

    most = float(np.log(MOST_VARIANCE))
    if lacking(0.0) <= 0:
        return 1.0
    if lacking(most) >= 0:
        return MOST_VARIANCE
    return float(np.exp(brentq(lacking, 0.0, most, xtol=0.05)))


def _rest(out: LeftOut, instrument_known: bool) -> float:
    """[m] rest: what errors e (k, 3) in the midst of the data have beside what is expected, per axis.

    The excess s = mean(|e|² - tr C) / 3, C expected, is rest² but for its own scatter σ, and may be negative.
    Where noise is large, σ hides a rest that bounds without that noise must have. As rest² >= 0, what s says
    of it is a normal cut off at zero, whose mean is taken (Box & Tiao 1973, where a variance component is
    estimated as negative):

        rest² = s + σ φ(s/σ) / Φ(s/σ)

    which is s where s is far above σ. σ is that of a mean over poses, whose points may err together, and at
    least that of independent errors as expected: one estimated alone is small where s is, by the same chance.
    """
    C = _covariance(out, instrument_known)
    excess = (_squared(out) - np.trace(C, axis1=1, axis2=2)) / 3
    s = float(excess.mean())
    together = np.linalg.norm(np.bincount(out.pose, excess - s))
    scatter = float(max(together, np.sqrt(2 * (C**2).sum()) / 3)) / len(excess)
    z = s / scatter
    mills = np.exp(-0.5 * z**2 - 0.5 * np.log(2 * np.pi) - log_ndtr(z))
    return float(np.sqrt(max(s + scatter * mills, 0.0)))


def _squared(out: LeftOut) -> Array:
    """(k,) [m²] squared errors, wild ones cut, and as much more as that takes off the mean of a χ² of 3."""
    squared = (out.error**2).sum(axis=1)
    largest = chdtri(3, 1 - WILD)
    left = chdtr(5, largest) + largest * (1 - WILD) / 3
    return np.asarray(np.minimum(squared, np.quantile(squared, WILD)) / left)


def _covariance(out: LeftOut, instrument_known: bool) -> Array:
    """(k, 3, 3) [m²] by the fitted numbers, the joints, and the instrument where it is known."""
    return out.fitted + out.scatter + out.seen * instrument_known


def _expected(out: LeftOut, instrument_known: bool) -> Array:
    """(k,) [m²] of squared errors, as far as `_covariance` knows of them."""
    return np.asarray(np.trace(_covariance(out, instrument_known), axis1=1, axis2=2))


def _robots_share(out: LeftOut, rest: float, instrument_known: bool) -> float:
    """Of the squared errors that are expected, what is not the instrument's noise."""
    own = _expected(out, instrument_known=False).mean() + 3 * rest**2
    return float(own / (_expected(out, instrument_known).mean() + 3 * rest**2))


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
