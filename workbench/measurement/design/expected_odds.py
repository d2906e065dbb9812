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
    def _spectra(self) -> list[Spectrum]:
        return [Spectrum.of(self.left[np.ix_(p.columns, p.columns)], p.sizes) for p in self.patterns]

    def evidence(self, k: int, truth: NDArray[np.int64], beta: Array) -> tuple[float, float]:
        """Twice the log evidence of the k-th pattern that is expected where the columns `truth` (t,) have the
        numbers `beta` (t,); and what it leaves of them, λ."""
        one = self.patterns[k]
        explained, value = self._spectra[k].of_scales(self.left[np.ix_(one.columns, truth)] @ beta)
        weights = np.where(one.named & (PRIORS.largest < SCALES), -np.inf, WEIGHTS)
        logs = 0.5 * value + weights
        whole = float(beta @ self.left[np.ix_(truth, truth)] @ beta)
        return 2 * float(np.logaddexp.reduce(logs)), max(whole - float(explained[np.argmax(logs)]), 0.0)

    def imitation(self, k: int, truth: NDArray[np.int64], beta: Array) -> Array:
        """(p,) numbers of the k-th pattern that imitate `beta` best, in its likeliest scale."""
        u = self.left[np.ix_(self.patterns[k].columns, truth)] @ beta
        _, value = self._spectra[k].of_scales(u)
        return self._spectra[k].imitation(u, float(SCALES[np.argmax(0.5 * value + WEIGHTS)]))


@dataclass(frozen=True, eq=False)
class Spectrum:
    """P S P = V diag(w) Vᵀ of one pattern: in these directions A is diagonal for every scale of the sizes.

    axes: (p, p) P V; w: (p,); rest: (scales,) what does not depend on the truth.
    """

    axes: Array
    w: Array
    rest: Array

    @classmethod
    def of(cls, S: Array, sizes: Array) -> Spectrum:
        w, V = np.linalg.eigh(S * np.outer(sizes, sizes))
        w = np.maximum(w, 0.0)
        seen = np.multiply.outer(SCALES**2, w)
        return cls(sizes[:, None] * V, w, np.sum(seen / (1 + seen) - np.log1p(seen), axis=1))

    def of_scales(self, u: Array) -> tuple[Array, Array]:
        """(scales,) uᵀA⁻¹u, and the same with `rest`."""
        squares = SCALES[:, None] ** 2
        explained = (squares / (1 + squares * self.w)) @ (self.axes.T @ u) ** 2
        return explained, explained + self.rest

    def imitation(self, u: Array, scale: float) -> Array:
        """(p,) A⁻¹u."""
        return np.asarray(self.axes @ ((self.axes.T @ u) * scale**2 / (1 + scale**2 * self.w)))


def share_of_way(gain: float, variance: float, needed: float) -> float:
    """How much of the records it takes these are, which bring this gain with this variance: with more of
    their kind both grow alike, and `needed` shall be reached but for `SURE` standard deviations."""
    if gain <= 0:
        return 0.0
    doubt = SURE * np.sqrt(max(variance, 0.0))
    return float((2 * gain / (doubt + np.sqrt(doubt**2 + 4 * gain * needed))) ** 2)
