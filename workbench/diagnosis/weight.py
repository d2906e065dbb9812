"""The weight of evidence for components beside a set: log Bayes factors over their forms and scales."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, log_ndtr, logsumexp

from ..robot.kinematics import Array
from .components import Component
from .priors import PRIORS
from .reduced import Index, Reduced

SCALES = np.array(PRIORS.scales)
WEIGHTS = np.log(SCALES / (1 + SCALES**2)) - logsumexp(np.log(SCALES / (1 + SCALES**2)))
NOTHING_OF_IT = -1e6  # log factor


@dataclass(frozen=True)
class Weight:
    """log odds of a component, prior included; its likeliest form and scale; and by how much more these are
    than in the forms alone that have no companions."""

    log_odds: float
    form: int
    scale: float
    by_companions: float = np.inf


def likelihood(left: Reduced, explained: float | Array, more: Array) -> Array:
    """Log likelihood gained by taking `more` off χ² beyond `explained`: Student's t, by how well the noise
    is known."""
    nu, n = left.noise_dof, left.dof
    total = nu + left.chi2
    before = np.maximum(total - explained, 1e-9 * total)
    after = np.maximum(before - more, 1e-9 * total)
    return np.asarray(-0.5 * (nu + n) * (np.log(after) - np.log(before)))


def prior_weight(component: Component, form: int, scale: float) -> float:
    """log prior odds of a component in one of its forms at one of the scales."""
    at = int(np.argmin(np.abs(SCALES - scale)))
    return float(component.log_odds + component.log_shares[form] + WEIGHTS[at])


def table_of(left: Reduced, S: Array, u: Array, explained: Array, wrong_sign: Array, own: Index) -> Array:
    """(F, scales) log Bayes factors of forms with columns S (F, p, p), u (F, p), weighed by the scales'
    priors. explained: (F,) what a set took off χ² before. own: (F,) number of an effect's
    own columns where companions follow, 0: none do."""
    q, log_det = _quadratic(S, u)
    table = likelihood(left, explained[:, None], q) - 0.5 * log_det + WEIGHTS
    alone = (wrong_sign != 0.5) & (own == 0)
    if alone.any():
        mean, covariance = _posterior(S[alone], u[alone], 1)
        z = mean[..., 0] / np.sqrt(covariance[..., 0, 0])
        table[alone] += np.log(2) + _sides(log_ndtr(z), log_ndtr(-z), wrong_sign[alone])
    for count in set(own[own > 0].tolist()):
        here = own == count
        mean, covariance = _posterior(S[here], u[here], count)
        table[here] += _present(mean[..., :count], covariance, wrong_sign[here])
        table[here] += mostly_itself(mean, count)
    return table


def most_of(left: Reduced, S: Array, u: Array, more: Array, rest: Array, own: Index) -> Array:
    """(F, scales, M) what `table_of` cannot exceed in the place of members without which a set explains rest
    (M,), where u is more (F, p, M) and S no less."""
    held = S[:, None] + SCALES[:, None, None] ** -2.0 * np.eye(S.shape[1])
    log_det = np.linalg.slogdet(held)[1] + 2 * S.shape[1] * np.log(SCALES)
    together = (u[:, :, None] + more)[:, None]
    q = (together * np.linalg.solve(held, together)).sum(axis=2)
    present = np.where(own > 0, -np.log(chdtrc(np.maximum(own, 1), PRIORS.present**2)), 0.0)
    return likelihood(left, rest, q) + (WEIGHTS - 0.5 * log_det + np.log(2) + present[:, None])[..., None]


def _quadratic(S: Array, u: Array) -> tuple[Array, Array]:
    """uᵀ (S + s⁻²)⁻¹ u and log |1 + s² S| of blocks S (F, p, p), u (F, p) for every scale s: (F, scales).

    The last row of the Cholesky factor of [[A, u], [uᵀ, c]] is L⁻¹ u, for any c that is large enough.
    """
    F, p = u.shape
    A = np.empty((F, len(SCALES), p + 1, p + 1))
    A[:, :, :p, :p] = S[:, None]
    A[:, :, np.arange(p), np.arange(p)] = (
        np.maximum(np.diagonal(S, axis1=1, axis2=2), 0.0)[:, None] * (1 + 1e-12) + SCALES[:, None] ** -2.0
    )
    A[:, :, p, :p] = A[:, :, :p, p] = u[:, None]
    A[:, :, p, p] = 1 + 2 * (u**2).sum(axis=1)[:, None] * SCALES**2
    L = np.linalg.cholesky(A)
    diagonal = np.diagonal(L, axis1=2, axis2=3)[..., :p]
    log_det = 2 * np.log(diagonal).sum(axis=2) + 2 * p * np.log(SCALES)
    return (L[:, :, p, :p] ** 2).sum(axis=2), log_det


def _posterior(S: Array, u: Array, count: int) -> tuple[Array, Array]:
    """Posterior mean (F, scales, p) of each block's numbers, and covariance of the first (count) of them."""
    A = S[:, None] + SCALES[:, None, None] ** -2.0 * np.eye(S.shape[1])
    right = np.zeros((*A.shape[:3], count + 1))
    right[..., range(count), range(count)], right[..., count] = 1.0, u[:, None]
    solved = np.asarray(np.linalg.solve(A, right), dtype=np.float64)
    return solved[..., count], solved[..., :count, :count]


def mostly_itself(mean: Array, count: int) -> Array:
    """(F, scales) log factor on the evidence that takes out what is not the effect, but its companions: these
    are larger, each in its prior size, than `PRIORS.companions` of the effect. mean: (F, scales, p)."""
    own, more = (np.sqrt((part**2).mean(axis=-1)) for part in np.split(mean, [count], axis=-1))
    return np.asarray(np.where(more > PRIORS.companions * own, NOTHING_OF_IT, 0.0))


def _sides(right: Array, wrong: Array, wrong_sign: Array) -> Array:
    """log probability of a sign that physics mostly holds, from those of either side (F, scales); wrong_sign:
    (F,) probability of the other before the data."""
    p = wrong_sign[:, None]
    return np.asarray(np.logaddexp(np.log1p(-p) + right, np.log(p) + wrong))


def _present(mean: Array, covariance: Array, wrong_sign: Array) -> Array:
    """(F, scales) log factor on the evidence where an effect is held to be no less than `PRIORS.present` of
    its scale: companions are a share of an effect that is there. It is the probability of that after the
    data over that before (Gelfand et al. 1992: a prior cut to a region)."""
    count, least = mean.shape[-1], PRIORS.present * SCALES
    before = np.log(chdtrc(count, PRIORS.present**2))
    if count == 1:
        sigma = np.sqrt(covariance[..., 0, 0])
        above, below = (log_ndtr((sign * mean[..., 0] - least) / sigma) for sign in (1, -1))
        return np.log(2) + _sides(above, below, wrong_sign) - before
    sigma = np.sqrt(np.trace(covariance, axis1=-2, axis2=-1) / count)
    after = log_ndtr((np.linalg.norm(mean, axis=-1) - least) / sigma)
    return np.asarray(after - before)
