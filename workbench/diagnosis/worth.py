"""What causes bring on poses that were held out: none stays that brings nothing, and where the likelihood is
too sure, none is surer than by that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from ..identification.fit import refit
from ..identification.heldout import heldout
from ..robot.kinematics import Array
from .competition import Selection
from .components import Key, bare
from .priors import PRIORS
from .stages import rms_mm, without

FAINT = 0.1  # of the noise, or of what is left per axis: a gain that decides nothing
NOTHING = 1e-30  # m²


def worth_it(selection: Selection, seed: int) -> Selection:
    """Without effects that bring the tool no nearer to its place on poses that they were not fitted on. Where
    something is left without a name, causes that bring less than a tenth of the noise keep none either."""
    kept, error = selection, rms_mm(heldout(selection.fit, seed=seed))
    while kept.fit.model.effects:
        gains = _gains(kept, error, seed)
        worst = int(np.argmin(gains))
        if gains[worst] > 0:
            break
        rest = [effect for i, effect in enumerate(kept.fit.model.effects) if i != worst]
        fit = refit(kept.fit, rest)
        after = rms_mm(heldout(fit, seed=seed))
        if after > error:
            break  # it holds others in place
        kept, error = replace(kept, fit=fit), after
    if kept.misfit:
        kept = as_sure_as_its_gain(kept, seed)
    result, nameless = kept.fit, kept.nameless
    if not nameless:
        return kept
    least = FAINT * max(1e3 * result.noise.usual, error / np.sqrt(3))
    alone = without(result, nameless, seed)
    gains_mm = {e.key: without(result, [*nameless, *own], seed) - alone for e, own in kept.groups}
    together = without(result, range(len(result.model.effects)), seed) - alone
    faint = frozenset(key for key, gain in gains_mm.items() if min(gain, together) < least)
    return replace(kept, faint=kept.faint | faint)


def as_sure_as_its_gain(selection: Selection, seed: int) -> Selection:
    """No name surer than that it brings poses that were held out nearer to their places than the best of as
    many causes would by chance, if none of them did anything (Šidák 1967). What has no name, or else nothing,
    gets the rest; a cause that leaves nearly all of it is faint."""
    fit, components = selection.fit, selection.components
    tried = sum(not component.nameless for component in components)
    rest = next((m.component for m in selection.members if components[m.component].nameless), None)
    position = fit.model.problem.positions
    whole = _squares(heldout(fit, seed=seed), position)
    shares, faint = [dict(share) for share in selection.shares], set[Key]()
    for effect, own in selection.groups:
        gain = _squares(heldout(fit, seed=seed, without=own), position) - whole
        sigma = max(gain.std(ddof=1) / np.sqrt(len(gain)), NOTHING)
        surest = float(ndtr(gain.mean() / sigma)) ** tried
        if surest < PRIORS.absent:
            faint.add(effect.key)
        for share, member in zip(shares, selection.members, strict=True):
            k = member.component
            if bare(components[k].key) == effect.key and share[k] > surest:
                share[rest] = share.get(rest, 0.0) + share[k] - surest
                share[k] = surest
    return replace(selection, shares=tuple(shares), faint=frozenset(faint))


def _squares(error: Array, position: NDArray[np.int64]) -> Array:
    """Mean square error [m²] of each joint position."""
    each = np.nansum(error**2, axis=(1, 2))
    return np.asarray(np.bincount(position, each) / np.bincount(position))


def _gains(selection: Selection, whole: float, seed: int) -> list[float]:
    """What each effect brings [mm] on poses held out: one with a name beside the others that have one, one
    without beside all. whole: RMS [mm] with all."""
    fit, nameless = selection.fit, selection.nameless
    named = without(fit, nameless, seed)
    return [
        without(fit, [i], seed) - whole if i in nameless else without(fit, [*nameless, i], seed) - named
        for i in range(len(fit.model.effects))
    ]
