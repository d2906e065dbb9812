"""What a fit leaves, against the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import chdtr, chdtrc, fdtrc

from ...effects.base import Effect
from ...identification.fit import Fit
from ...identification.noise import Covariance, repeat_chi2
from ...identification.repeats import scatter_of_repeats
from ...robot.description import Robot
from ...robot.kinematics import Array
from .screen import effective_dof, reduce_columns

GLOBAL_LEVEL = 1e-3  # chance that clean data's residual exceeds the noise
INFLATED = 1.10  # residual over noise from which scatter counts as something left
# ISO 9283 RP per sigma of an axis: mean and three standard deviations of the length (Maxwell's distribution)
RP = float(np.sqrt(8 / np.pi) + 3 * np.sqrt(3 - 8 / np.pi))
ORDINARY_MM = 0.05  # RP up to which a robot whose data sheet says no more is believed to scatter
DENIED = 0.01  # chance that repeats scatter as little, were it the robot that does not repeat


@dataclass(frozen=True)
class Remainder:
    """chi2, dof, p of the residual against the noise (p NaN where the noise is the residual's own).
    inflation: residual over noise; scatter: far more than noise; overstated: far less than the noise."""

    chi2: float
    dof: float
    p: float
    inflation: float
    scatter: bool

    @property
    def overstated(self) -> bool:
        return bool(1 - self.p < GLOBAL_LEVEL and self.inflation < 1 / INFLATED)

    def excess(self, sigma: float) -> float:
        """One sigma per axis of what is left beyond a noise of `sigma`, in its unit."""
        return sigma * float(np.sqrt(max(self.inflation**2 - 1, 0.0)))


def remainder(result: Fit, known: bool) -> Remainder:
    """χ² test of what a fit leaves; F where the noise was measured with few repeats."""
    return _tested(result, result.chi2, effective_dof(result), known)


def beyond_forms(result: Fit, known: bool, companions: Sequence[tuple[Effect, Array]]) -> Remainder:
    """The same of what is left where real causes are off their forms: companions of the fit's effects, with
    their prior sizes (p,), take their share."""
    G = np.concatenate([result.whitened(effect) * sizes for effect, sizes in companions], axis=2)
    S, u, _ = reduce_columns(result, G)
    L = np.linalg.cholesky(S + np.eye(len(S)))
    taken = solve_triangular(L, u, lower=True, check_finite=False)
    kept = solve_triangular(L, np.eye(len(L)), lower=True, check_finite=False)
    used = len(L) - float((kept**2).sum())
    return _tested(result, result.chi2 - float(taken @ taken), effective_dof(result) - used, known)


def _tested(result: Fit, chi2: float, dof: float, known: bool) -> Remainder:
    if not known:
        p = float("nan")
    elif np.isinf(result.noise.dof):
        p = float(chdtrc(dof, chi2))
    else:
        p = float(fdtrc(dof, result.noise.dof, chi2 / dof))
    inflation = float(np.sqrt(chi2 / dof))
    return Remainder(chi2, dof, p, inflation, bool(known and p < GLOBAL_LEVEL and inflation > INFLATED))


def rp_mm(sigma: float) -> float:
    """ISO 9283 RP [mm] of a robot that scatters by one sigma [m] per axis."""
    return 1e3 * RP * sigma


def ordinary_mm(robot: Robot) -> float:
    """ISO 9283 RP [mm] up to which a robot's scatter is its repeatability: its data sheet's, or an ordinary
    robot's if that is more."""
    return max(robot.pose_repeatability_mm or 0.0, ORDINARY_MM)


def repeatability_mm(final: Fit, left: Remainder, noise: Covariance) -> float | None:
    """ISO 9283 RP [mm] of a robot that would scatter as the residual does beyond a stated noise; None where
    it does not, where that is no ordinary robot's, or where the repeatability is known.

    What nobody measured is no cause: an instrument's data sheet leaves out how the robot repeats, and a
    calibration comes from all sides to its poses, once to each. noise: what was stated."""
    problem = final.model.problem
    if not left.scatter or noise.joint.any():
        return None
    if np.isfinite(noise.dof) and scatter_of_repeats(problem)[2]:
        return None
    found = rp_mm(left.excess(noise.usual))
    if found > ordinary_mm(problem.robot):
        return None
    if not problem.campaign.six_dof:
        chi2, dof = repeat_chi2(problem, noise.times(left.inflation), final.line.by_joint)
        if dof and chdtr(dof, chi2) < DENIED:
            return None
    return found
