"""What the data allow at best: how often one who knows a shape would report it, by the same priors."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.special import logsumexp
from scipy.stats import norm

from ...diagnosis.priors import PRIORS
from ...diagnosis.weighing.weight import SCALES, WEIGHTS

FAR = 40.0  # standard deviations


def reported_at_best(strength: float, places: int) -> float:
    """Chance that something of a strength λ would be reported, were its shape known to the last column and
    its noise exactly, and only its size not: the posterior of nothing there (`PRIORS.absent`) decides. No
    rival stands beside it, no form is off, so no diagnosis reports more.

    With a column of length √λ per usual size, z ~ N(√λ, 1) is what the data say of it, and a size s · usual
    has the evidence −½ log(1 + s² λ) + ½ z² s² λ/(1 + s² λ). places: those that share the cause's
    probability.
    """
    p = PRIORS.cause / places
    odds = np.log(p / (1 - p)) - np.log(1 / PRIORS.absent - 1)
    seen = SCALES**2 * strength

    def over(z: float) -> float:
        evidence = WEIGHTS - 0.5 * np.log1p(seen) + 0.5 * z**2 * seen / (1 + seen)
        return float(odds + logsumexp(evidence))

    least = float(brentq(over, 0.0, FAR))
    centre = np.sqrt(strength)
    return float(norm.sf(least - centre) + norm.cdf(-least - centre))
