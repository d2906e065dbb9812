"""How likely a diagnosis names what is true after further records, as likely as its hypotheses are now.

What is true is drawn from what is known: a hypothesis by its probability, its numbers β with those of its
companions from their posterior, so that a map of a joint that looked like a sine so far may turn out as any
map that looks so. With the information S on all columns of effects, now S₀, the data come down to u = S β +
noise of covariance S, and further records add to u₀ what has the mean (S − S₀) β and the covariance S − S₀.
Each drawn u is weighed as a diagnosis does it: forms in their prior sizes P and scales, with A = S_i + P⁻²
twice the log evidence of a form is u_iᵀA⁻¹u_i − log |1 + P S_i P| (Kass & Raftery 1995), and odds are no
surer than forms are true (`diagnosis.stand_ins`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...diagnosis.priors import PRIORS
from ...diagnosis.weighing.weight import SCALES, WEIGHTS, mostly_itself
from ...robot.kinematics import Array

DRAWS = 200  # of what may be true: the probability is good to 0.03
SPARE = 2.0  # of log evidence beyond what a name takes: a real cause is off its form, and rivals take of that
LARGEST = 500.0  # log odds that floats hold


@dataclass(frozen=True, eq=False)
class Pattern:
    """A form of a hypothesis: its columns (p,) among the effects', their prior sizes (p,), the effect's own
    numbers first. of: number of the hypothesis; own: how many these are; named: it has a name, so no scale
    beyond what passes for a cause."""

    columns: NDArray[np.int64]
    sizes: Array
    of: int
    own: int
    named: bool = True


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """What may be true: H hypotheses in their forms. chances: (H,) probabilities now, up to a factor; slow:
    (H, H) by how much log odds between two are too sure; named: (H,) which have a name; less: (H, H) log of
    by how much less likely the second was than the first before the data."""

    patterns: tuple[Pattern, ...]
    chances: Array
    slow: Array
    named: NDArray[np.bool_]
    less: Array


@dataclass(frozen=True, eq=False)
class Expected:
    """named: probability that a diagnosis names what is true, of what has a name, by its probability and by
    what the data alone say, with `SPARE` log odds to spare; believed: mean probability that it gives to what
    is true."""

    named: float
    believed: float


@dataclass(frozen=True, eq=False)
class Weighed:
    """Patterns under information `left` (g, g) on the effects' columns."""

    left: Array
    patterns: Sequence[Pattern]

    @cached_property
    def _spectra(self) -> list[tuple[Array, Array]]:
        """(p, p) P V and (p,) w of each pattern, P S P = V diag(w) Vᵀ: in these directions A is diagonal for
        every scale of the sizes."""
        out = []
        for one in self.patterns:
            w, V = np.linalg.eigh(
                self.left[np.ix_(one.columns, one.columns)] * np.outer(one.sizes, one.sizes)
            )
            out.append((one.sizes[:, None] * V, np.maximum(w, 0.0)))
        return out

    def of_scales(self, k: int, u: Array) -> tuple[Array, Array]:
        """(D, scales) log evidence of the k-th pattern in D data u (D, g), and what it explains of them."""
        axes, w = self._spectra[k]
        squares = SCALES[:, None] ** 2
        explained = (u[:, self.patterns[k].columns] @ axes) ** 2 @ (squares / (1 + squares * w)).T
        one = self.patterns[k]
        weights = np.where(one.named & (PRIORS.largest < SCALES), -np.inf, WEIGHTS)
        logs = 0.5 * (explained - np.log1p(squares * w).sum(axis=1)) + weights
        if one.own < len(one.sizes):
            held = (squares / (1 + squares * w))[None] * (u[:, one.columns] @ axes)[:, None]
            logs = logs + mostly_itself(held @ (axes / one.sizes[:, None]).T, one.own)
        return logs, explained

    def standing(self, u: Array, hypotheses: int) -> tuple[Array, Array]:
        """(H, D) log evidence of the hypotheses in D data u (D, g); what their likeliest form explains."""
        evidence, explained = (np.full((hypotheses, len(u)), start) for start in (-np.inf, 0.0))
        likeliest = np.full((hypotheses, len(u)), -np.inf)
        for k, one in enumerate(self.patterns):
            logs, takes = self.of_scales(k, u)
            best = logs.argmax(axis=1)
            top, its = logs[np.arange(len(u)), best], takes[np.arange(len(u)), best]
            better = top > likeliest[one.of]
            explained[one.of] = np.where(better, its, explained[one.of])
            likeliest[one.of] = np.maximum(likeliest[one.of], top)
            every = top + np.log(np.exp(logs - top[:, None]).sum(axis=1))
            evidence[one.of] = np.logaddexp(evidence[one.of], every)
        return evidence, explained

    def draw(self, h: int, u: Array, count: int, rng: np.random.Generator) -> Array:
        """(count, g) numbers of a hypothesis from their posterior in data u (g,)."""
        forms = [k for k, one in enumerate(self.patterns) if one.of == h]
        logs = np.concatenate([self.of_scales(k, u[None])[0][0] for k in forms])
        share = np.exp(logs - logs.max())
        out = np.zeros((count, len(u)))
        for row, pick in enumerate(rng.choice(len(share), size=count, p=share / share.sum())):
            k, scale = forms[pick // len(SCALES)], SCALES[pick % len(SCALES)]
            (axes, w), columns = self._spectra[k], self.patterns[k].columns
            variance = scale**2 / (1 + scale**2 * w)
            at = variance * (axes.T @ u[columns]) + np.sqrt(variance) * rng.standard_normal(len(w))
            out[row, columns] = axes @ at
        return out


@dataclass(frozen=True, eq=False)
class Outlook:
    """What is expected of further records. now: (g, g) information so far on the effects' columns; u: (g,)
    the data so far; seed: of the draws, the same for every plan, so that plans differ by what they are."""

    now: Array
    u: Array
    hypotheses: Hypotheses
    seed: int = 29

    @cached_property
    def _chances(self) -> Array:
        """(H,) probability of each that has a name, were it one of these."""
        chances = np.where(self.hypotheses.named, self.hypotheses.chances, 0.0)
        return np.asarray(chances / chances.sum())

    @cached_property
    def _true(self) -> list[tuple[int, Array, Array]]:
        """Hypotheses that may be true: number, drawn numbers (D, g), and as many draws of the noise."""
        before, rng = Weighed(self.now, self.hypotheses.patterns), np.random.default_rng(self.seed)
        out = []
        for h in np.flatnonzero(self._chances):
            count = int(np.ceil(DRAWS * self._chances[h]))
            beta = before.draw(int(h), self.u, count, rng)
            out.append((int(h), beta, rng.standard_normal(beta.shape)))
        return out

    @cached_property
    def _standing(self) -> tuple[Array, Array]:
        return Weighed(self.now, self.hypotheses.patterns).standing(self.u[None], len(self._chances))

    def after(self, then: Array) -> Expected:
        """Where further records make the information `then` (g, g) of it."""
        after, told = Weighed(then, self.hypotheses.patterns), self.hypotheses
        added = then - self.now
        w, V = np.linalg.eigh(added)
        root = V * np.sqrt(np.maximum(w, 0.0)) @ V.T
        sure, by_data = (share / (1 - share) for share in (PRIORS.named, PRIORS.by_data))
        named, believed = 0.0, 0.0
        drawn = [self.u + beta @ added + noise @ root for _, beta, noise in self._true]
        every = after.standing(np.concatenate(drawn), len(self._chances))
        ends = np.cumsum([len(u) for u in drawn])
        for (h, _, _), *standing in zip(
            self._true, *(np.split(x, ends[:-1], axis=1) for x in every), strict=True
        ):
            gained = _odds(standing, h, told) - _odds(self._standing, h, told)
            odds = np.log(told.chances / told.chances[h])[:, None] + gained / told.slow[h][:, None]
            spare = (SPARE / told.slow[h])[:, None]
            alike = spare + told.less[h][:, None]
            others, nearly, raised = (_sum_but(h, odds + more) for more in (0.0, spare, alike))
            settled = (nearly * sure <= 1) & (raised * by_data <= 1)
            named += self._chances[h] * float(np.mean(settled))
            believed += self._chances[h] * float(np.mean(1 / (1 + others)))
        return Expected(named, believed)


def _sum_but(h: int, odds: Array) -> Array:
    """(D,) odds of all hypotheses but the h-th together, from the log odds (H, D) of each."""
    return np.asarray(np.exp(np.minimum(np.delete(odds, h, axis=0), LARGEST)).sum(axis=0))


def _odds(standing: Sequence[Array], h: int, hypotheses: Hypotheses) -> Array:
    """(H, D) log odds of the hypotheses over the h-th as a diagnosis believes them: what one fits better than
    another counts as far as forms are true; functions without a name, which have no form, may be worse."""
    evidence, explained = standing
    better = 0.5 * (explained - explained[h])
    too_sure = 1 - 1 / (1 + PRIORS.form**2 * explained[h])
    free = ~hypotheses.named[:, None] & (better < 0)
    return np.asarray(evidence - evidence[h] - np.where(free, 0.0, better * too_sure))
