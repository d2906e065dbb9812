"""Bounds of lengths of Gaussian vectors."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri

from ...robot.kinematics import Array

LEVEL = 0.95
MOST_DOF = 1e6  # from here on a length is as good as certain


def length_bound(covariance: Array, mean: Array | None = None) -> Array:
    """(...) length that a Gaussian vector of covariance (..., 3, 3) and mean (..., 3) exceeds in 5 %.

    The squared length as a multiple of χ² with its first two moments (Satterthwaite 1946).
    """
    trace = np.trace(covariance, axis1=-2, axis2=-1)
    spread = 2 * np.einsum("...ij,...ji->...", covariance, covariance)
    if mean is not None:
        trace = trace + (mean**2).sum(axis=-1)
        spread = spread + 4 * np.einsum("...i,...ij,...j->...", mean, covariance, mean)
    known = spread > 0
    dof = np.minimum(2 * trace**2 / np.where(known, spread, 1.0), MOST_DOF)
    dof = np.where(known, dof, MOST_DOF)
    return np.asarray(np.sqrt(trace / dof * chdtri(dof, 1 - LEVEL)))
