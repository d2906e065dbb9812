"""Accounts of how printed numbers came to be, each judged by all that is printed.

An account is a story that can be simulated: its free values are drawn from what may be assumed, and it says
what the paper would have printed. `judge` draws each many times and asks how the print lies among its draws.
All accounts are judged by the same items: what an account does not speak about it has to predict as well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import logsumexp

from ..robot.kinematics import Array
from .evidence import LEAST, Evidence, evidence, spread
from .priors import Prior

LEAST_DRAWS = 8  # of their weight, that a free value is read from
MISSED = 0.05  # of its draws as far out as the print, or fewer: the account misses it


@dataclass(frozen=True)
class Item:
    """A printed number, or row of k numbers.

    value: as printed; sd: of each, from its rounding and the scatter that the paper states (> 0), in the
    value's unit; place: where it is printed; ratio: compared as logarithm (value > 0).
    """

    name: str
    words: str
    value: ArrayLike
    sd: ArrayLike
    place: str
    ratio: bool = False

    def __post_init__(self) -> None:
        value, sd = np.atleast_1d(self.value), np.atleast_1d(self.sd)
        if (sd <= 0).any() or (self.ratio and (value <= 0).any()):
            raise ValueError(f"{self.name}: sd, and value where a ratio is compared, have to be above zero")

    def compared(self, values: ArrayLike) -> Array:
        """(k,) numbers as they are compared; what has no logarithm is NaN."""
        given = np.atleast_1d(np.asarray(values, dtype=float))
        if not self.ratio:
            return given
        return np.asarray(np.log(np.where(given > 0, given, np.nan)))

    @property
    def target(self) -> tuple[Array, Array]:
        """(k,) the print and its standard deviations, as they are compared."""
        value, sd = np.broadcast_arrays(np.atleast_1d(self.value), np.atleast_1d(self.sd))
        return self.compared(value), np.asarray(sd / value if self.ratio else sd, dtype=float)


Predict = Callable[[Mapping[str, float], np.random.Generator], Mapping[str, ArrayLike]]


@dataclass(frozen=True)
class Account:
    """A story of how the print came to be.

    priors: its free values; predict: their values and a random generator → item name → (k,) what would have
    been printed (NaN: these values print nothing). It runs in other processes: a function of a module, or
    a `partial` of one with things that can be pickled.
    """

    name: str
    words: str
    priors: Mapping[str, Prior]
    predict: Predict


def target_of(items: Sequence[Item]) -> tuple[Array, Array]:
    """(K,) all that is printed, and its standard deviations, as compared, side by side."""
    value, sd = zip(*(item.target for item in items), strict=True)
    return np.concatenate(value), np.concatenate(sd)


@dataclass(frozen=True)
class Standing:
    """How a print stands among the draws of an account. share: of the draws lie as far from their middle as
    the print; distance: of the print from there in standard deviations (root mean square of its numbers),
    infinite where fewer than `LEAST` draws print anything."""

    share: float
    distance: float

    @property
    def reproduced(self) -> bool:
        return self.share > MISSED


@dataclass(frozen=True)
class Round:
    """Draws of an account.

    shares: (D, P) free values as shares of their ranges; predicted: (D, K) all items side by side, as
    compared; prior: (D,) logarithm of the prior over the density that each was drawn from.
    """

    shares: Array
    predicted: Array
    prior: Array


@dataclass(frozen=True)
class Judged:
    """Accounts held against items. first: account → draws from its priors; last: those near the print."""

    accounts: Sequence[Account]
    items: Sequence[Item]
    first: Mapping[str, Round]
    last: Mapping[str, Round]
    seed: int

    def columns(self, item: str) -> slice:
        """Where an item's numbers stand in `predicted`."""
        start = 0
        for given in self.items:
            size = len(given.target[0])
            if given.name == item:
                return slice(start, start + size)
            start += size
        raise KeyError(item)

    @property
    def target(self) -> tuple[Array, Array]:
        """(K,) all that is printed, and its standard deviations."""
        return target_of(self.items)

    def standing(self, account: str, item: str | None = None) -> Standing:
        """Of an item, or of all together."""
        at = slice(None) if item is None else self.columns(item)
        made = self.first[account].predicted[:, at]
        value, sd = (part[at] for part in self.target)
        good = made[np.isfinite(made).all(axis=1)]
        if len(good) < LEAST:
            return Standing(0.0, np.inf)
        found = spread(good)
        shaken = good + sd * np.random.default_rng([self.seed, 7]).normal(size=good.shape)
        far = float(found.distance(value, sd)[0])
        share = float((found.distance(shaken, sd) >= far).sum()) / len(made)
        return Standing(share, far)

    def evidences(self, without: str | None = None) -> dict[str, Evidence]:
        """Of each account, from all items or all but one (then from its first draws)."""
        keep = np.ones(len(self.target[0]), dtype=bool)
        if without is not None:
            keep[self.columns(without)] = False
        value, sd = (part[keep] for part in self.target)
        rounds = self.last if without is None else self.first
        return {
            name: evidence(r.predicted[:, keep], value, sd, r.prior, self.seed) for name, r in rounds.items()
        }

    @cached_property
    def evidence(self) -> dict[str, Evidence]:
        """Of each account, from all items."""
        return self.evidences()

    def probabilities(self, without: str | None = None) -> dict[str, float]:
        """Of each account, if all were as probable before the print was seen and there were no other."""
        found = self.evidence if without is None else self.evidences(without)
        logs = np.array([each.log10 for each in found.values()])
        if not np.isfinite(logs).any():
            return dict.fromkeys(found, np.nan)
        shares = 10 ** (logs - logs.max())
        return dict(zip(found, (shares / shares.sum()).tolist(), strict=True))

    @cached_property
    def without(self) -> dict[str, dict[str, float]]:
        """Item → what the probabilities would be without it; nothing where it is the only one."""
        names = [item.name for item in self.items]
        return {name: self.probabilities(name) for name in names} if len(names) > 1 else {}

    @property
    def best(self) -> str:
        """The account of the highest evidence."""
        return max(self.evidence, key=lambda name: self.evidence[name].log10)

    def odds(self, account: str, over: str | None = None) -> tuple[float, float]:
        """log₁₀ odds of an account over another, or over the best, and their Monte-Carlo error."""
        one, other = self.evidence[account], self.evidence[over or self.best]
        return one.log10 - other.log10, float(np.hypot(one.error, other.error))

    def excluded(self, account: str, odds: float, by: str | None = None) -> bool:
        """Whether another account, or the best, has more than such odds over an account, beyond their
        error."""
        behind, error = self.odds(account, by)
        return bool(-behind > np.log10(odds) + error)

    def needed(self, account: str, value: str) -> tuple[float, float, float]:
        """5, 50 and 95 % of a free value, once the print is seen (NaN: no draw comes near).

        Weighted draws, corrected by linear regression for what their numbers miss the print by (Beaumont et
        al. 2002).
        """
        priors = next(a for a in self.accounts if a.name == account).priors
        logs, near = self.evidence[account].logs, self.last[account]
        good = np.isfinite(logs)
        if not good.any():
            return (np.nan, np.nan, np.nan)
        weights = np.exp(logs[good] - logsumexp(logs[good]))
        if 1 / (weights**2).sum() < LEAST_DRAWS:
            return (np.nan, np.nan, np.nan)
        target, sd = self.target
        root, made = np.sqrt(weights)[:, None], near.predicted[good]
        missed = made + sd * np.random.default_rng([self.seed, 8]).normal(size=made.shape) - target
        shares = near.shares[good, list(priors).index(value)]
        rows = np.column_stack([np.ones(len(missed)), missed])
        slope = np.linalg.lstsq(root * rows, root[:, 0] * shares)[0]
        shares = np.clip(shares - missed @ slope[1:], 0.0, 1.0)
        order = np.argsort(shares)
        kept = weights[order]
        ends = np.interp([0.05, 0.5, 0.95], np.cumsum(kept) - kept / 2, shares[order])
        low, middle, high = (priors[value].at(float(end)) for end in ends)
        return low, middle, high

    def numbers(self, *, without: bool = True) -> dict[str, float]:
        """For a story: seed; account_draws, of each account; p_ACCOUNT its probability,
        p_ACCOUNT_without_ITEM; log10_ACCOUNT and log10_ACCOUNT_error its evidence; share_ACCOUNT_ITEM and
        far_ACCOUNT_ITEM its standings (ITEM: all for all together); ACCOUNT_VALUE, ACCOUNT_VALUE_low and
        ACCOUNT_VALUE_high what it needs.

        without: with the probabilities without each item.
        """
        found = {f"p_{name}": p for name, p in self.probabilities().items()}
        drawn = len(next(iter(self.first.values())).shares)
        found |= {"seed": float(self.seed), "account_draws": float(drawn)}
        left_out = self.without if without else {}
        for account in self.accounts:
            a = account.name
            found |= {f"log10_{a}": self.evidence[a].log10, f"log10_{a}_error": self.evidence[a].error}
            found |= {f"p_{a}_without_{item}": shares[a] for item, shares in left_out.items()}
            for item in (*(i.name for i in self.items), None):
                stands = self.standing(a, item)
                found |= {
                    f"share_{a}_{item or 'all'}": stands.share,
                    f"far_{a}_{item or 'all'}": stands.distance,
                }
            for value in account.priors:
                low, middle, high = self.needed(a, value)
                found |= {f"{a}_{value}": middle, f"{a}_{value}_low": low, f"{a}_{value}_high": high}
        return found
