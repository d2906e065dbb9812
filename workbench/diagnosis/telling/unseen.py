"""How far the numbers of causes may be off by what is there beside them, too small to be found.

A number is as sure as its fit says only where the arm is true to its model in all that was not found. No arm
is: each of its masses, springs and bearings is a little off, and what they do together in the directions of a
cause that was found goes into the number of that (omitted variables). So these all stand beside the fit, each
with a prior of a share of its usual size, the share as likely as the data have it; and a number is as far off
as it then is in the mean square: by its variance, and by where it would have gone. Forces from outside are as
true as the cell that measured them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.special import logsumexp

from ...effects.base import Effect
from ...effects.unnamed.loads import StatedForces
from ...identification.fit import Fit
from ...robot.kinematics import Array
from ..priors import PRIORS
from ..weighing.components import Key, is_alike, usual
from ..weighing.screen import along_own

Sized = tuple[Effect, Array]  # with its prior sizes (p,)


def allowing_for_unseen(fit: Fit, companions: Sequence[Sized], candidates: Sequence[Effect]) -> Array:
    """(P, P) mean squares of how far a fit's numbers are off. companions: what its causes have beside their
    forms, in their sizes."""
    there = {(effect.key, effect.variant) for effect in fit.model.effects}
    forces = [(one, usual(fit, one)) for one in StatedForces.sites(fit.model.problem)]
    known = _new([*_of_the_same_bodies(fit, candidates), *companions, *forces], there)
    unseen = _new(_elsewhere(fit, candidates), there)
    every = [*known, *unseen]
    if not every:
        return fit.covariance
    G = np.concatenate([fit.whitened(e) * size for e, size in every], axis=2).reshape(fit.r.size, -1)
    Z = along_own(fit, G)
    S, u = G.T @ G - Z.T @ Z, G.T @ fit.r.ravel()
    taken = -solve_triangular(fit.upper, Z) * fit.columns.prior[:, None]  # by the fit's numbers
    own = sum(len(size) for _, size in known)
    scales = [scale for scale in PRIORS.scales if scale <= 1.0] if unseen else [1.0]
    odds, squares = [], []
    for scale in scales:
        d = np.where(np.arange(len(S)) < own, 1.0, scale)
        factor = cho_factor(np.eye(len(S)) + d[:, None] * S * d)
        mean = d * cho_solve(factor, d * u)
        half = solve_triangular(factor[0], d[:, None] * taken.T, trans="T")  # cho_factor: upper
        squares.append(half.T @ half + np.outer(taken @ mean, taken @ mean))
        odds.append(0.5 * u @ mean - np.log(np.diag(factor[0])).sum() + np.log(scale / (1 + scale**2)))
    weights = np.exp(odds - logsumexp(odds))
    return np.asarray(fit.covariance + np.einsum("k,kij->ij", weights, np.array(squares)))


def _new(sized: Iterable[Sized], there: set[tuple[Key, str]]) -> list[Sized]:
    """Those that are not there yet, each once; they are then."""
    found = []
    for effect, size in sized:
        if (effect.key, effect.variant) not in there:
            there.add((effect.key, effect.variant))
            found.append((effect, size))
    return found


def _elsewhere(fit: Fit, candidates: Sequence[Effect]) -> Iterator[Sized]:
    """What bends an arm under its loads where nothing was found, in usual sizes: of each place one form, and
    of a body its mass and its centre."""
    found, had = {effect.key for effect in fit.model.effects}, set[tuple[Key, str]]()
    for effect in candidates:
        place = effect.key, effect.variant if effect.together else ""
        # not all joints alike: each is here by itself
        if effect.by_loads and not is_alike(effect) and effect.key not in found and place not in had:
            had.add(place)
            yield effect, usual(fit, effect)


def _of_the_same_bodies(fit: Fit, candidates: Sequence[Effect]) -> Iterator[Sized]:
    """Of what was found to be off, the parts that come together with it, by as many usual sizes."""
    off = dict[Key, float]()
    for i, effect in enumerate(fit.model.effects):
        if effect.together and not effect.is_held:
            size = np.abs(fit.effect_values(i)[0] / usual(fit, effect)).max()
            off[effect.key] = max(off.get(effect.key, 0.0), float(size))
    for effect in candidates:
        if effect.by_loads and effect.key in off:
            yield effect, off[effect.key] * usual(fit, effect)
