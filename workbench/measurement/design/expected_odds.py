"""What a diagnosis is expected to say of an effect and its rivals after further records: twice the log Bayes
factors, weighed as it weighs them (sizes, scales and companions of `diagnosis.components`).

Were β the truth in the columns t, the information S on all columns makes u = S_t β of the columns i of a
form; with A = S_i + P⁻² for prior sizes P, the mean over the noise of twice its log evidence is
uᵀA⁻¹u + tr A⁻¹S_i − log |1 + P S_i P| (Kass & Raftery 1995). A difference of two such that grows by g with
further records has a standard deviation of 2 √λ, λ what the rival leaves of β more than before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.special import logsumexp

from ...diagnosis.priors import PRIORS
from ...diagnosis.weight import SCALES, WEIGHTS
from ...robot.kinematics import Array

SURE = 1.28  # standard deviations: nine of ten follow-ups bring it


@dataclass(frozen=True, eq=False)
class Pattern:
    """A form of a hypothesis: its columns (p,) among the effects', their prior sizes (p,), the effect's own
    numbers first. named: it has a name, so no scale beyond what passes for a cause."""

    columns: NDArray[np.int64]
    sizes: Array
    named: bool = True


@dataclass(frozen=True, eq=False)
class Weighed:
    """Patterns under information `left` (g, g) on the effects' columns."""

    left: Array
    patterns: Sequence[Pattern]

    @cached_property
    def _factors(self) -> list[list[tuple[tuple[Array, bool], float]]]:
        """Per pattern and scale: Cholesky factor of A, and what does not depend on the truth."""
        return [[self._factor(one, scale * one.sizes) for scale in SCALES] for one in self.patterns]

    def _factor(self, one: Pattern, size: Array) -> tuple[tuple[Array, bool], float]:
        S = self.left[np.ix_(one.columns, one.columns)]
        factor = cho_factor(S + np.diag(size**-2.0))
        log_det = 2 * float(np.log(np.diag(factor[0])).sum() + np.log(size).sum())
        return factor, float(np.trace(cho_solve(factor, S))) - log_det

    def evidence(self, k: int, truth: NDArray[np.int64], beta: Array) -> tuple[float, float]:
        """Twice the log evidence of the k-th pattern that is expected where the columns `truth` (t,) have the
        numbers `beta` (t,); and what it leaves of them, λ."""
        one = self.patterns[k]
        u = self.left[np.ix_(one.columns, truth)] @ beta
        explained = np.array([float(u @ cho_solve(factor, u)) for factor, _ in self._factors[k]])
        value = explained + [rest for _, rest in self._factors[k]]
        weights = np.where(one.named & (PRIORS.largest < SCALES), -np.inf, WEIGHTS)
        logs = 0.5 * value + weights
        whole = float(beta @ self.left[np.ix_(truth, truth)] @ beta)
        return 2 * float(logsumexp(logs)), max(whole - float(explained[np.argmax(logs)]), 0.0)

    def imitation(self, k: int, truth: NDArray[np.int64], beta: Array) -> Array:
        """(p,) numbers of the k-th pattern that imitate `beta` best, in its likeliest scale."""
        one = self.patterns[k]
        u = self.left[np.ix_(one.columns, truth)] @ beta
        logs = [0.5 * (float(u @ cho_solve(f, u)) + rest) for f, rest in self._factors[k]] + WEIGHTS
        return np.asarray(cho_solve(self._factors[k][int(np.argmax(logs))][0], u))


def share_of_way(gain: float, variance: float, needed: float) -> float:
    """How much of the records it takes these are, which bring this gain with this variance: with more of
    their kind both grow alike, and `needed` shall be reached but for `SURE` standard deviations."""
    if gain <= 0:
        return 0.0
    doubt = SURE * np.sqrt(max(variance, 0.0))
    return float((2 * gain / (doubt + np.sqrt(doubt**2 + 4 * gain * needed))) ** 2)
