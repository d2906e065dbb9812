"""The likeliest variances of what a noise is made of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from ...identification.variances import cost_of
from ...robot.kinematics import Array

EXACT, BEYOND = 1e-9, 100.0  # of the variance that one part would have alone: what is fitted lies between
CLEARLY = 20.0  # twice the log likelihood that a further part of the noise must bring


def with_more(
    d: Array, mask: NDArray[np.bool_], parts: Sequence[Array], few: int, lost: float
) -> list[float]:
    """One sigma of each of the parts, as `likeliest`: zero of those after the first few, where it is not
    clear that these are there."""
    least, cost_least = likeliest(d, mask, parts[:few], lost)
    every, cost_every = likeliest(d, mask, parts, lost)
    clear = cost_least - cost_every >= CLEARLY
    variances = every if clear else np.append(least, np.zeros(len(parts) - few))
    return [float(sigma) for sigma in np.sqrt(variances)]


def likeliest(d: Array, mask: NDArray[np.bool_], parts: Sequence[Array], lost: float) -> tuple[Array, float]:
    """Variances (k,) of covariances that add up to that of d (N, D), parts: k of (N, D, D), and twice the
    negative log likelihood of them. lost: by how much a fit made d smaller."""
    unseen = np.where(mask, 0.0, 1.0)[:, :, None] * np.eye(mask.shape[1])

    def cost(x: Array) -> tuple[float, Array]:
        """By the variances' logarithms, and its gradient."""
        variances = np.exp(x)
        value, slope = cost_of(variances, d, unseen, parts, lost)
        return value, variances * slope

    each = np.array([np.trace(part, axis1=1, axis2=2).sum() for part in parts])
    alone = np.log(float((d**2).sum()) / np.maximum(each, 1e-300))  # were it all there is
    bounds = [(one + np.log(EXACT), one + np.log(BEYOND)) for one in alone]
    found = minimize(cost, alone - np.log(len(parts)), jac=True, method="L-BFGS-B", bounds=bounds)
    return np.exp(found.x), float(found.fun)
