"""What hangs on the odds of a run, over more runs: the accounts' draws drawn again out of themselves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from .accounts import Judged, Round
from .draws import Draws

AGAIN = 50  # runs that a claim about the odds is checked over


def redrawn(judged: Judged, numbers: Callable[[Judged], Mapping[str, float]], runs: int = AGAIN) -> Draws:
    """What `numbers` finds where each account's draws are drawn again out of themselves, with a seed of its
    own (bootstrap, Efron 1979): as many draws as there are, so that what chance they had shows."""
    found = [numbers(_again(judged, run)) for run in range(runs)]
    return Draws({}, {}, {name: np.array([one[name] for one in found], dtype=float) for name in found[0]})


def _again(judged: Judged, run: int) -> Judged:
    rng = np.random.default_rng([judged.seed, 11, run])
    first = {name: _taken(made, rng) for name, made in judged.first.items()}
    last = {
        name: first[name] if made is judged.first[name] else _taken(made, rng)
        for name, made in judged.last.items()
    }
    return replace(judged, first=first, last=last, seed=int(rng.integers(2**31)))


def _taken(made: Round, rng: np.random.Generator) -> Round:
    """Every other draw and the rest by themselves, for `calibrated` judges by one half and tries on the
    other; and so what prints anything and what does not, so that there are as many of each to judge by."""
    every = np.arange(len(made.prior))
    prints, take = np.isfinite(made.predicted).all(axis=1), every.copy()
    for first in (0, 1):
        for kept in (prints, ~prints):
            part = every[kept & (every % 2 == first)]
            take[part] = rng.choice(part, size=len(part)) if len(part) else part
    return Round(made.shares[take], made.predicted[take], made.prior[take])
