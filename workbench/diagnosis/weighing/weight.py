"""The weight of evidence for components beside a set: log Bayes factors over their forms and scales."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, log_ndtr, logsumexp

from ...robot.kinematics import Array
from ..priors import PRIORS
from .components import Component
from .reduced import Index, Reduced

SCALES = np.array(PRIORS.scales)
WEIGHTS = np.log(SCALES / (1 + SCALES**2)) - logsumexp(np.log(SCALES / (1 + SCALES**2)))
SQUARES = SCALES[:, None] ** 2
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


@dataclass(frozen=True, eq=False)
class _Spectra:
    """Blocks S (F, p, p) in the directions V (F, p, p) in which they are diagonal: so are S + s⁻² and its
    inverse `held` (F, scales, p) for every scale s."""

    V: Array
    held: Array

    @classmethod
    def of(cls, S: Array) -> _Spectra:
        w, V = np.linalg.eigh(S)
        return cls(V, SQUARES / (1 + SQUARES * np.maximum(w, 0.0)[:, None]))

    @property
    def log_det(self) -> Array:
        """(F, scales) log |1 + s² S|."""
        return np.asarray(-np.log(self.held / SQUARES).sum(axis=2))

    def along(self, u: Array) -> Array:
        """(F, p, M) of M times u (F, p, M) along each direction."""
        return np.asarray(self.V.swapaxes(1, 2) @ u)

    def posterior(self, along: Array, here: NDArray[np.bool_], count: int) -> tuple[Array, Array]:
        """Posterior mean (F, scales, p) of the numbers of some blocks, of which u is `along` (F, p), and
        covariance of the first (count) of them."""
        V, held = self.V[here], self.held[here]
        first = V[:, None, :count]
        mean = (held * along[here, None]) @ V.swapaxes(1, 2)
        return mean, (first * held[:, :, None]) @ first.swapaxes(2, 3)


def table_of(left: Reduced, S: Array, u: Array, explained: Array, wrong_sign: Array, own: Index) -> Array:
    """(F, scales) log Bayes factors of forms with columns S (F, p, p), u (F, p), weighed by the scales'
    priors. explained: (F,) what a set took off χ² before. own: (F,) number of an effect's
    own columns where companions follow, 0: none do."""
    spectra = _Spectra.of(S)
    along = spectra.along(u[..., None])[..., 0]
    q = (spectra.held * along[:, None] ** 2).sum(axis=2)
    table = likelihood(left, explained[:, None], q) - 0.5 * spectra.log_det + WEIGHTS
    alone = (wrong_sign != 0.5) & (own == 0)
    if alone.any():
        mean, covariance = spectra.posterior(along, alone, 1)
        z = mean[..., 0] / np.sqrt(covariance[..., 0, 0])
        table[alone] += np.log(2) + _sides(log_ndtr(z), log_ndtr(-z), wrong_sign[alone])
    for count in set(own[own > 0].tolist()):
        here = own == count
        mean, covariance = spectra.posterior(along, here, count)
        table[here] += _present(mean[..., :count], covariance, wrong_sign[here])
        table[here] += mostly_itself(mean, count)
    return table


def most_of(left: Reduced, S: Array, u: Array, more: Array, rest: Array, own: Index) -> Array:
    """(F, scales, M) what `table_of` cannot exceed in the place of members without which a set explains rest
    (M,), where u is more (F, p, M) and S no less."""
    spectra = _Spectra.of(S)
    q = spectra.held @ spectra.along(u[:, :, None] + more) ** 2
    present = np.where(own > 0, -np.log(chdtrc(np.maximum(own, 1), PRIORS.present**2)), 0.0)
    fixed = WEIGHTS - 0.5 * spectra.log_det + np.log(2) + present[:, None]
    return likelihood(left, rest, q) + fixed[..., None]


def mostly_itself(mean: Array, count: int) -> Array:
    """(F, scales) log factor on the evidence that takes out what is not the effect, but its companions: these
    are larger, each in its prior size, than `PRIORS.companions` of the effect. mean: (F, scales, p)."""
    own, more = (np.einsum("...p,...p->...", x, x) for x in (mean[..., :count], mean[..., count:]))
    most = PRIORS.companions**2 * (mean.shape[-1] - count) / count
    return np.where(more > most * own, NOTHING_OF_IT, 0.0)


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
