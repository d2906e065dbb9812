"""Scatter from pose to pose that the noise does not hold, of single joints and of all targets together: a
variance, not a cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear, minimize

from ..identification.fit import Fit
from ..identification.noise import Covariance, body_motion
from ..identification.rows import whitening
from ..identification.variances import cost_of
from ..robot.kinematics import Array
from .screen import effective_dof

CLEAR = 4.0  # standard deviations of its estimate from which a joint's variance counts
SHOWN = 1e-2  # rad, m: a joint that moves the points by less than the noise on such a way shows no scatter
TOGETHER = 8.0  # twice the log likelihood from which a pose's targets scatter together
POSES_PER_JOINT = 10  # different joint positions, per joint, from which a variance can be told from causes


def with_scatter(fit: Fit, base: Covariance) -> Covariance:
    """The noise `base` with the scatter in a fit's residual, of the joints and of what carries the targets;
    the fit was made with that or more."""
    return _of_body(fit, _of_joints(fit, base))


def _of_joints(fit: Fit, base: Covariance) -> Covariance:
    """With the joints' own scatter, by moments: E[(gⱼᵀr)²] = |gⱼ|² + Σₖ (gⱼᵀgₖ)² (σₖ² − cₖ²), summed over the
    poses, for the whitened motions gⱼ of the points by each joint, and the variances cₖ² that the whitening
    has already."""
    arm = fit.model.problem.arm
    if positions(fit) < POSES_PER_JOINT * arm.n:
        return base
    g = fit.axial
    free = fit.point_rows / max(effective_dof(fit), 1.0)
    score = np.einsum("ndj,nd->nj", g, fit.r) * np.sqrt(free)
    cross = np.einsum("ndj,ndk->njk", g, g)
    own = np.einsum("njj->nj", cross)
    had = fit.noise.joint**2 - base.joint**2
    shown = np.flatnonzero(own.mean(axis=0) > SHOWN**-2)
    if not len(shown):
        return base
    weight = 1 / (own[:, shown] ** 2).sum(axis=0)
    A = (cross**2).sum(axis=0)[np.ix_(shown, shown)] * weight[:, None]
    b = (score**2 - own).sum(axis=0)[shown] * weight
    unit = max(float(np.abs(b).max()), 1e-30)  # the tolerance is absolute; an interior method stops short
    found = unit * lsq_linear(A, b / unit, bounds=(-had[shown] / unit - 1e-9, np.inf), method="bvls").x
    extra = np.zeros(arm.n)
    extra[shown] = np.maximum(had[shown] + found, 0.0)
    extra[shown[extra[shown] < CLEAR * np.sqrt(2 * weight)]] = 0.0
    return replace(base, joint=np.sqrt(base.joint**2 + extra))


def _of_body(fit: Fit, base: Covariance) -> Covariance:
    """With one variance of shifts and one of turns of a pose's targets together, beside `base`: maximum
    likelihood in the six motions of the body that carries them, which is all that these variances touch.

    A robot that nobody knows the repeatability of scatters so, and every other thing that acts on a whole
    pose. Were a pose's targets taken for as many independent witnesses, chance would look like a cause."""
    problem = fit.model.problem
    several = problem.seen.sum(axis=1) > 1
    if problem.campaign.six_dof or not several.any():
        return base
    W = whitening(problem, fit.line, base)[several][:, :, : 3 * problem.seen.shape[1]]
    Q, R = np.linalg.qr(W @ body_motion(problem)[several])
    residual = np.nan_to_num(fit.residual).reshape(len(several), -1)[several]
    y = np.einsum("ndk,nd->nk", Q, np.einsum("nde,ne->nd", W, residual))
    free = fit.point_rows / max(effective_dof(fit), 1.0)
    parts = [R[:, :, part] @ R[:, :, part].transpose(0, 2, 1) for part in (slice(0, 3), slice(3, 6))]

    def cost(x: Array) -> tuple[float, Array]:
        """By the variances, each over its usual one, and its gradient: by the logarithm of a variance that is
        next to nothing there is no slope."""
        value, slope = cost_of(x * unit, y, np.eye(6), parts, free)
        return value, unit * slope

    unit = np.array([1 / max(float(np.trace(p, axis1=1, axis2=2).mean()) / 3, 1e-30) for p in parts])
    found = minimize(cost, np.ones(2), jac=True, method="L-BFGS-B", bounds=[(0.0, None)] * 2, tol=1e-12)
    if cost(np.zeros(2))[0] - found.fun < TOGETHER:
        return base
    shift, turn = np.sqrt(found.x * unit + np.square(base.body)).tolist()
    return replace(base, body=(shift, turn))


def positions(fit: Fit) -> int:
    """Number of different joint positions."""
    return int(fit.model.problem.positions.max(initial=-1)) + 1


def alike(one: Covariance, other: Covariance) -> bool:
    """Whether two noises differ by less than a tenth: the instrument's, in any joint, and the body's."""
    pairs = (one.joint, other.joint), (one.body, other.body)
    robot = all(np.allclose(a, b, rtol=0.1, atol=1e-7) for a, b in pairs)
    return bool(robot and np.isclose(one.usual, other.usual, rtol=0.1))
