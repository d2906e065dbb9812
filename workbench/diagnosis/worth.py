"""What causes bring on poses that were held out: none stays that brings nothing, and where the likelihood is
too sure, none is surer than by that."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtr

from ..effects.base import Effect
from ..identification.fit import Fit, refit
from ..identification.heldout import heldout
from .competition import Selection
from .components import Key, bare
from .priors import PRIORS
from .stages import rms_mm, without

FAINT = 0.1  # of the noise, or of what is left per axis: a gain that decides nothing
NOTHING = 1e-30  # m²


def worth_it(selection: Selection, seed: int) -> Selection:
    """Without effects that bring the tool no nearer to its place on poses that they were not fitted on. Where
    something is left without a name, causes that bring less than a tenth of the noise keep none either.

    Causes that can stand in for each other each bring next to nothing beside the others. So each counts by
    what it brings beside these, or by what it brings to those that are stronger, whichever is more."""
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
    together = without(result, range(len(result.model.effects)), seed) - without(result, nameless, seed)
    gains_mm = {
        effect.key: max(
            without(result, [*beside, *own], seed) - without(result, beside, seed)
            for beside in (nameless, [*nameless, *weaker])
        )
        for effect, own, weaker in _by_strength(kept)
    }
    faint = frozenset(key for key, gain in gains_mm.items() if min(gain, together) < least)
    return replace(kept, faint=kept.faint | faint)


def _by_strength(selection: Selection) -> Iterator[tuple[Effect, list[int], list[int]]]:
    """Each named cause, strongest first: one of its effects, the numbers of all of these in the fit, and
    those of the causes that are weaker."""
    groups = selection.groups
    for k, (effect, own) in enumerate(groups):
        yield effect, own, [i for _, others in groups[k + 1 :] for i in others]


def as_sure_as_its_gain(selection: Selection, seed: int) -> Selection:
    """No name surer than that it brings poses that were held out nearer to their places than the best of as
    many causes would by chance, if none of them did anything (Šidák 1967); but for those that parts of the
    data found by themselves. What has no name, or else nothing, gets the rest; a cause that leaves nearly all
    of it is faint."""
    fit, components = selection.fit, selection.components
    tried = sum(not component.nameless for component in components)
    rest = next((m.component for m in selection.members if components[m.component].nameless), None)
    shares, faint = [dict(share) for share in selection.shares], set[Key]()
    for effect, own, weaker in _by_strength(selection):
        if effect.key in selection.agreed:
            continue
        alone = [*selection.nameless, *weaker]
        surest = max(_chance(fit, beside, own, seed) for beside in ([], alone)) ** (2 * tried)
        if surest < PRIORS.absent:
            faint.add(effect.key)
        for share, member in zip(shares, selection.members, strict=True):
            k = member.component
            if bare(components[k].key) == effect.key and share[k] > surest:
                share[rest] = share.get(rest, 0.0) + share[k] - surest
                share[k] = surest
    return replace(selection, shares=tuple(shares), faint=frozenset(faint))


def _chance(fit: Fit, beside: Sequence[int], own: Sequence[int], seed: int) -> float:
    """That effects which do nothing would bring less on poses held out, without those `beside`: by the mean
    of what they take off a position's square error, over its standard error."""
    position = fit.model.problem.positions
    with_it, without_it = (heldout(fit, seed=seed, without=out) for out in (beside, [*beside, *own]))
    each = np.nansum(without_it**2 - with_it**2, axis=(1, 2))
    gain = np.bincount(position, each) / np.bincount(position)
    return float(ndtr(gain.mean() / max(gain.std(ddof=1) / np.sqrt(len(gain)), NOTHING)))


def _gains(selection: Selection, whole: float, seed: int) -> list[float]:
    """What each effect brings [mm] on poses held out: one without a name beside all, one with a name beside
    the others that have one, or to those that are stronger, if that is more. whole: RMS [mm] with all."""
    fit, nameless = selection.fit, selection.nameless
    named = without(fit, nameless, seed)
    gains = [0.0] * len(fit.model.effects)
    for i in nameless:
        gains[i] = without(fit, [i], seed) - whole
    for _, own, weaker in _by_strength(selection):
        out = [*nameless, *weaker]
        for i in own:
            gains[i] = without(fit, [*nameless, i], seed) - named
            if gains[i] <= 0:
                gains[i] = max(gains[i], without(fit, [*out, i], seed) - without(fit, out, seed))
    return gains
