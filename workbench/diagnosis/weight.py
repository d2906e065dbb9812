"""The weight of evidence for one component beside a set: log Bayes factor over its forms and scales."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp, ndtr

from ..robot.kinematics import Array
from .components import Component
from .priors import PRIORS
from .reduced import Reduced

SCALES = np.array(PRIORS.scales)
WEIGHTS = np.log(SCALES / (1 + SCALES**2)) - logsumexp(np.log(SCALES / (1 + SCALES**2)))


@dataclass(frozen=True)
class Weight:
    """log odds of a component, prior included; and its likeliest form and scale."""

    log_odds: float
    form: int
    scale: float


def likelihood(left: Reduced, explained: float, more: Array) -> Array:
    """Log likelihood gained by taking `more` off χ² beyond `explained`: Student's t, by how well the noise
    is known."""
    nu, n = left.noise_dof, left.dof
    total = nu + left.chi2
    before = np.maximum(total - explained, 1e-9 * total)
    after = np.maximum(before - more, 1e-9 * total)
    return np.asarray(-0.5 * (nu + n) * (np.log(after) - np.log(before)))


def weigh(left: Reduced, k: int, component: Component, explained: float) -> Weight:
    """Weight of component k when a set is in; left: what the set leaves; explained: what it took off χ²."""
    table = np.empty((len(component.forms), len(SCALES)))
    for f, (form, part) in enumerate(zip(component.forms, left.parts[k], strict=True)):
        S, u = left.S[part, part], left.u[part]
        d, V = np.linalg.eigh(S)
        d, y = np.maximum(d, 0.0), V.T @ u
        s2 = SCALES[:, None] ** 2
        q = (s2 * y**2 / (1 + s2 * d)).sum(axis=1)
        table[f] = likelihood(left, explained, q) - 0.5 * np.log1p(s2 * d).sum(axis=1) + WEIGHTS
        if form.one_sided:
            z = y[0] * V[0, 0] * SCALES / np.sqrt(1 + SCALES**2 * d[0])
            wrong = PRIORS.wrong_sign
            table[f] += np.log(2 * ((1 - wrong) * ndtr(z) + wrong * ndtr(-z)))
    best = np.unravel_index(int(np.argmax(table)), table.shape)
    total = logsumexp(table) - np.log(len(component.forms))
    return Weight(float(total + component.log_odds), int(best[0]), float(SCALES[best[1]]))
