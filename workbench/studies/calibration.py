"""Odds of accounts that are as right as they say: calibrated on worlds that the accounts made themselves.

The likelihood of the printed numbers is the Gaussian one of an account's draws from its whole ranges
(synthetic likelihood, Wood 2010). With few draws of many numbers such odds are too sure of themselves. So
worlds are drawn from the accounts, each is judged as the print is, and all logarithms of likelihoods are
divided by the one number, the temper, under which the right accounts get the highest probability on average
(as forecasts are calibrated, Guo et al. 2017). The print has no part in that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import logsumexp

from ..report.numbers import decimals, percent, probability
from ..report.study import Table
from ..robot.kinematics import Array
from .accounts import Judged
from .evidence import LEAST, spread

TEMPERS = 0.5, 100.0
STATED = 0.0, 0.3, 0.5, 0.7, 0.9, 1.0  # ends of the classes of a stated probability


@dataclass(frozen=True, eq=False)
class Calibrated:
    """Odds of A accounts. logs: (A,) ln of the print's likelihood; worlds: (W, A) the same of the worlds;
    made: (W,) the number of the account that made each."""

    names: Sequence[str]
    logs: Array
    worlds: Array
    made: NDArray[np.signedinteger]
    temper: float

    @property
    def probabilities(self) -> dict[str, float]:
        """Of each account, if all were as probable before."""
        return dict(zip(self.names, shares(self.logs, self.temper).tolist(), strict=True))

    @property
    def before(self) -> dict[str, float]:
        """The same without temper."""
        return dict(zip(self.names, shares(self.logs, 1.0).tolist(), strict=True))

    def against(self, some: Sequence[str], others: Sequence[str]) -> float:
        """Probability of some accounts against others, if both groups were as probable before."""
        return float(self._against(self.logs, some, others))

    def told(self, some: Sequence[str], others: Sequence[str]) -> float:
        """Share of the groups' own worlds, each group counted as half, in which the right one has more."""
        given = self._against(self.worlds, some, others)
        halves = []
        for group, right in ((some, given > 0.5), (others, given < 0.5)):
            at = np.isin(self.made, [self.names.index(name) for name in group])
            halves.append(right[at].mean())
        return float(np.mean(halves))

    def _against(self, logs: Array, some: Sequence[str], others: Sequence[str]) -> Array:
        group = [
            logsumexp(logs[..., [self.names.index(n) for n in each]] / self.temper, axis=-1)
            - np.log(len(each))
            for each in (some, others)
        ]
        return np.asarray(1 / (1 + np.exp(np.clip(group[1] - group[0], -700, 700))))

    @property
    def right(self) -> float:
        """Share of the worlds in which the account that made it has the highest probability."""
        return float((self.worlds.argmax(axis=1) == self.made).mean())

    def stated(self, temper: float) -> list[tuple[float, float, int, float]]:
        """By classes of the highest probability: from, to, worlds, and the share in which it was right."""
        p = shares(self.worlds, temper)
        best, right = p.max(axis=1), p.argmax(axis=1) == self.made
        out = []
        for low, high in pairwise(STATED):
            at = (best > low) & (best <= high)
            out.append((low, high, int(at.sum()), float(right[at].mean()) if at.any() else np.nan))
        return out


def shares(logs: Array, temper: float) -> Array:
    """(..., A) probabilities from logarithms of likelihoods."""
    given = logs / temper
    return np.asarray(np.exp(given - logsumexp(given, axis=-1, keepdims=True)))


def calibrated(judged: Judged, items: Sequence[str]) -> Calibrated:
    """Odds from some of the items, by the first draws of each account: every other draw says how likely, the
    rest are the worlds. Raises ValueError where an account has too few draws that print anything."""
    at = np.r_[tuple(judged.columns(item) for item in items)]
    value, sd = (part[at] for part in judged.target)
    rng = np.random.default_rng([judged.seed, 9])
    names = [account.name for account in judged.accounts]
    made = {name: judged.first[name].predicted[:, at] for name in names}
    worlds = {name: drawn[1::2][np.isfinite(drawn[1::2]).all(axis=1)] for name, drawn in made.items()}
    noisy = np.vstack([one + sd * rng.normal(size=one.shape) for one in worlds.values()])
    halves = {name: drawn[::2] for name, drawn in made.items()}
    logs = likelihoods(halves, noisy, sd)
    label = np.repeat(np.arange(len(names)), [len(one) for one in worlds.values()])

    def missed(log_temper: float) -> float:
        given = shares(logs, float(np.exp(log_temper)))[range(len(label)), label]
        return -float(np.log(np.maximum(given, 1e-300)).mean())

    found = minimize_scalar(missed, bounds=tuple(np.log(TEMPERS)), method="bounded")
    return Calibrated(names, likelihoods(made, value[None], sd)[0], logs, label, float(np.exp(found.x)))


def likelihoods(made: Mapping[str, Array], prints: Array, sd: Array) -> Array:
    """(N, A) ln of the likelihood of prints (N, K), uncertain by sd (K,), by draws (D, K) of each account."""
    out = []
    for name, drawn in made.items():
        good = drawn[np.isfinite(drawn).all(axis=1)]
        if len(good) < LEAST:
            raise ValueError(f"{name}: {len(good)} draws print anything, too few to judge by")
        found = spread(good)
        _, determinant = np.linalg.slogdet(found.covariance + np.diag(sd**2))
        far = found.distance(prints, sd) ** 2 * len(sd)
        out.append(np.log(len(good) / len(drawn)) - (far + determinant + len(sd) * np.log(2 * np.pi)) / 2)
    return np.column_stack(out)


def calibrated_table(found: Calibrated, judged: Judged) -> Table:
    """Each account's probability as computed and as calibrated, and how often its own worlds tell it.

    found: as `calibrated` gives it for judged, which `judge` gave.
    """
    rows = []
    highest = found.worlds.argmax(axis=1)
    for i, account in enumerate(judged.accounts):
        own = highest[found.made == i]
        rows.append(
            [
                account.words,
                probability(found.before[account.name]),
                probability(found.probabilities[account.name]),
                f"{percent(float((own == i).mean()), 0)} of {len(own)}",
            ]
        )
    head = ("Account", "As computed", "Calibrated", "Highest in its own worlds")
    note = (
        "All accounts as probable before, and no other thought of. Synthetic Gaussian likelihood of each "
        f"account’s draws; calibrated: its logarithm over {decimals(found.temper, 1)}, as {len(found.made)} "
        "worlds that the accounts made themselves ask for. Last column: how often the account that made a "
        f"world gets the highest probability; {percent(1 / len(found.names), 0)} would be chance."
    )
    return Table("Probabilities of the accounts, calibrated on worlds of their own", head, rows, note)


def stated_table(found: Calibrated) -> Table:
    """How often the account with the highest probability made the world, by what was stated."""
    rows = []
    both = zip(found.stated(1.0), found.stated(found.temper), strict=True)
    for (low, high, count, right), (_, _, counted, truly) in both:
        rows.append(
            [
                f"{percent(low, 0)} to {percent(high, 0)}",
                *(
                    f"{percent(share, 0)} of {n}" if n else "–"
                    for n, share in ((count, right), (counted, truly))
                ),
            ]
        )
    return Table(
        "How often the account stated as most probable is the right one",
        ("Stated probability", "As computed: right in", "Calibrated: right in"),
        rows,
        "Worlds drawn from all accounts alike.",
    )
