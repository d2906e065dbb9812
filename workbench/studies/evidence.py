"""How probable printed numbers are among draws of an account: the density of the draws where the print lies.

Each draw is a Gaussian bump: as wide as the print's own uncertainty, and a kernel beside it, h² of the draws'
covariance with all draws taken towards their middle by √(1 − h²), so that their covariance stays (West 1993).
With many draws of few numbers h is small and the density is that of approximate Bayesian computation; with
few draws of many numbers h comes near 1 and it is a single Gaussian (a synthetic likelihood). Where the print
lies far outside all draws the density is an order of magnitude only, as its error then says.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from ..robot.kinematics import Array

CLIPPED = 4.0  # of the draws' scale: what lies farther out says no more about their covariance
RESAMPLED = 200
LEAST = 10  # draws that print anything, to say how a print lies among them


@dataclass(frozen=True)
class Evidence:
    """log10: of the density at the print; error: one standard deviation of its Monte-Carlo error, or what
    half the kernel changes, whichever is larger; logs: (D,) natural logarithm of what each draw carries."""

    log10: float
    error: float
    logs: Array


@dataclass(frozen=True)
class Spread:
    """Middle (K,) and covariance (K, K) of draws, not moved by what lies far out."""

    middle: Array
    covariance: Array

    def distance(self, points: Array, sd: Array) -> Array:
        """(N,) root of the mean of squares of what points (N, K) miss the middle by, in standard deviations
        of the draws with the print's own uncertainty sd (K,) on top."""
        lower = np.linalg.cholesky(self.covariance + np.diag(sd**2))
        missed = np.linalg.solve(lower, (np.atleast_2d(points) - self.middle).T)
        return np.asarray(np.sqrt((missed**2).mean(axis=0)))


def spread(drawn: Array) -> Spread:
    """Of draws (D, K), D ≥ 2: the median; the covariance of what is clipped to a few scales of 16 to 84 %."""
    count, size = drawn.shape
    low, middle, high = np.quantile(drawn, [0.16, 0.5, 0.84], axis=0)
    scale = np.maximum((high - low) / 2, 1e-300)
    clipped = np.clip((drawn - middle) / scale, -CLIPPED, CLIPPED)
    covariance = np.atleast_2d(np.cov(clipped.T)) * np.outer(scale, scale)
    if count < 10 * size:  # too few for a full covariance
        share = size / (count + size)
        covariance = (1 - share) * covariance + share * np.diag(np.diag(covariance))
    return Spread(middle, covariance)


def evidence(drawn: Array, value: Array, sd: Array, prior: Array | None = None, seed: int = 0) -> Evidence:
    """Of a print value (K,) with uncertainty sd (K,) among draws (D, K). A draw that is not finite could not
    have made the print; it counts as one that misses it. prior: (D,) logarithm of the prior over the density
    that each was drawn from; None: drawn from the prior."""
    good = np.isfinite(drawn).all(axis=1)
    logs = np.full(len(drawn), -np.inf)
    if good.sum() < LEAST:
        return Evidence(-np.inf, 0.0, logs)
    carried = np.zeros(len(drawn)) if prior is None else prior
    logs[good] = carried[good] + _bumps(drawn[good], value, sd, 1.0)
    whole = _log10_mean(logs)
    narrow = _log10_mean(carried[good] + _bumps(drawn[good], value, sd, 0.5)) + np.log10(good.mean())
    again = np.random.default_rng([seed, len(drawn)]).integers(len(drawn), size=(RESAMPLED, len(drawn)))
    means = np.exp(logs - logs.max())[again].mean(axis=1)
    return Evidence(whole, max(float(np.std(np.log10(means[means > 0]))), abs(narrow - whole)), logs)


def _bumps(drawn: Array, value: Array, sd: Array, narrower: float) -> Array:
    """(D,) log density of each draw's bump at the print."""
    count, size = drawn.shape
    width = narrower * min(1.0, (4 / (size + 2) / count) ** (1 / (size + 4)))
    found = spread(drawn)
    centres = found.middle + np.sqrt(1 - width**2) * (drawn - found.middle)
    lower = np.linalg.cholesky(width**2 * found.covariance + np.diag(sd**2))
    missed = np.linalg.solve(lower, (value - centres).T)
    return np.asarray(
        -0.5 * (missed**2).sum(axis=0) - np.log(np.diag(lower)).sum() - size / 2 * np.log(2 * np.pi)
    )


def _log10_mean(logs: Array) -> float:
    return float((logsumexp(logs) - np.log(len(logs))) / np.log(10))
