"""Where to draw an account's free values next: near those that came nearest to the print.

Free values are shares of their ranges, so the prior is 1 on the unit cube. A round after the first draws from
a mixture of kernels about the draws before it, by how near they came, and of the whole range; each draw
carries the prior over the mixture's density (population Monte Carlo, Cappé et al. 2004).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp, ndtr, ndtri

from ..robot.kinematics import Array

WHOLE = 0.1  # of the draws come from the whole range
LEAST_WEIGHT = 1e-9  # of a draw that a kernel is put about
LEAST_ALIVE = 30.0  # draws that share the weight, at least
WIDTH = 0.7  # of a kernel, over the spread of what it is made of


@dataclass(frozen=True)
class Proposal:
    """A mixture over the unit cube. centres: (C, P); weights: (C,), sum 1; width: (P,)."""

    centres: Array
    weights: Array
    width: Array

    def draw(self, rng: np.random.Generator) -> Array:
        """(P,) shares."""
        if rng.random() < WHOLE:
            return rng.random(len(self.width))
        middle = self.centres[rng.choice(len(self.weights), p=self.weights)]
        low, high = ndtr(-middle / self.width), ndtr((1 - middle) / self.width)
        inside = low + (high - low) * rng.random(len(middle))
        return np.asarray(middle + self.width * ndtri(inside))

    def log_density(self, shares: Array) -> Array:
        """(D,) at shares (D, P)."""
        z = (shares[:, None] - self.centres) / self.width
        inside = ndtr((1 - self.centres) / self.width) - ndtr(-self.centres / self.width)
        kernels = -0.5 * (z**2 + np.log(2 * np.pi)).sum(axis=2) - np.log(self.width * inside).sum(axis=1)
        mixed = logsumexp(kernels + np.log(self.weights), axis=1)
        return np.asarray(np.logaddexp(np.log(WHOLE), np.log(1 - WHOLE) + mixed))


def proposal(shares: Array, logs: Array) -> Proposal:
    """From draws (D, P) with the logarithms of their weights (D,), flattened until enough of them share."""
    good = np.isfinite(logs)
    shares, logs = shares[good], logs[good]
    enough = min(LEAST_ALIVE, len(logs) / 2)
    low, high = 0.0, 1.0
    for _ in range(40):
        power = (low + high) / 2
        low, high = (power, high) if _alive(power * logs) > enough else (low, power)
    weights = np.exp(low * logs - logsumexp(low * logs))
    middle = weights @ shares
    width = WIDTH * np.sqrt(weights @ (shares - middle) ** 2)
    counts = weights > LEAST_WEIGHT
    return Proposal(shares[counts], weights[counts] / weights[counts].sum(), np.maximum(width, 1e-4))


def _alive(logs: Array) -> float:
    """How many draws share the weight (Kish)."""
    return float(np.exp(2 * logsumexp(logs) - logsumexp(2 * logs)))
