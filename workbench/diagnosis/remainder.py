"""What a fit leaves, against the noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, fdtrc

from ..identification.fit import Fit
from .screen import effective_dof

GLOBAL_LEVEL = 1e-3  # chance that clean data's residual exceeds the noise
INFLATED = 1.10  # residual over noise from which scatter counts as something left


@dataclass(frozen=True)
class Remainder:
    """chi2, dof, p of the residual against the noise (p NaN where the noise is the residual's own).
    inflation: residual over noise; scatter: far more than noise."""

    chi2: float
    dof: float
    p: float
    inflation: float
    scatter: bool


def remainder(result: Fit, known: bool) -> Remainder:
    """χ² test of what a fit leaves; F where the noise was measured with few repeats."""
    dof, chi2 = effective_dof(result), result.chi2
    if not known:
        p = float("nan")
    elif np.isinf(result.noise.dof):
        p = float(chdtrc(dof, chi2))
    else:
        p = float(fdtrc(dof, result.noise.dof, chi2 / dof))
    inflation = float(np.sqrt(chi2 / dof))
    return Remainder(chi2, dof, p, inflation, bool(known and p < GLOBAL_LEVEL and inflation > INFLATED))
