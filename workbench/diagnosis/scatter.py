"""Scatter of single joints from pose to pose that the noise does not hold: a variance, not a cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from ..identification.fit import Fit
from ..identification.noise import Covariance
from .screen import effective_dof

CLEAR = 4.0  # standard deviations of its estimate from which a joint's variance counts
POSES_PER_JOINT = 10  # different joint positions, per joint, from which a variance can be told from causes


def with_scatter(fit: Fit, base: Covariance) -> Covariance:
    """The noise `base` with the joints' own scatter in a fit's residual; the fit was made with that or more.

    By moments: E[(gⱼᵀr)²] = |gⱼ|² + Σₖ (gⱼᵀgₖ)² (σₖ² − cₖ²), summed over the poses, for the whitened motions
    gⱼ of the points by each joint, and the variances cₖ² that the whitening has already.
    """
    arm = fit.model.problem.arm
    if positions(fit) < POSES_PER_JOINT * arm.n:
        return base
    g = np.matmul(fit.whitener, fit.line.direct[:, :, arm.axial])
    free = fit.point_rows / max(effective_dof(fit), 1.0)
    score = np.einsum("ndj,nd->nj", g, fit.r) * np.sqrt(free)
    cross = np.einsum("ndj,ndk->njk", g, g)
    own = np.einsum("njj->nj", cross)
    had = fit.noise.joint**2 - base.joint**2
    weight = 1 / np.maximum((own**2).sum(axis=0), 1e-300)
    A = (cross**2).sum(axis=0) * weight[:, None]
    b = (score**2 - own).sum(axis=0) * weight
    unit = max(float(np.abs(b).max()), 1e-30)  # the solver's tolerance is absolute
    found = unit * lsq_linear(A, b / unit, bounds=(-had / unit - 1e-9, np.inf)).x
    extra = np.maximum(had + found, 0.0)
    extra[extra < CLEAR * np.sqrt(2 * weight)] = 0.0
    return replace(base, joint=np.sqrt(base.joint**2 + extra))


def positions(fit: Fit) -> int:
    """Number of different joint positions."""
    return int(fit.model.problem.positions.max(initial=-1)) + 1


def alike(one: Covariance, other: Covariance) -> bool:
    """Whether two noises differ by less than a tenth: the instrument's, in any joint, and the body's."""
    pairs = (one.joint, other.joint), (one.body, other.body)
    robot = all(np.allclose(a, b, rtol=0.1, atol=1e-7) for a, b in pairs)
    return bool(robot and np.isclose(one.usual, other.usual, rtol=0.1))
