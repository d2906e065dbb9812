"""What real causes have beside the forms that they are known by, fitted with them once they are named.

The competition counts it: companions stand beside each form, so that no cause is dropped for being off it.
Here they join the model where the data show them: no ground is alike in all directions, and a path is bent
by all of what the ground does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...effects.base import Effect
from ...identification.fit import ROUGH, Fit, refit
from ...identification.heldout import heldout
from ...identification.noise import Covariance
from ..noise.scatter import with_scatter
from ..weighing.components import Key, bare, beside_forms
from ..weighing.remainder import remainder
from ..weighing.stand_ins import SURELY
from .competition import Selection
from .rounds import BETTER
from .stages import rms_mm, without


def with_own_forms(selection: Selection, noise: Covariance, noise_known: bool, seed: int) -> Selection:
    """The selection with what its named causes have beside their forms, as large as these are likeliest,
    where without it more than noise is left, and with it poses held out are predicted better. noise: without
    the scatter that the search took for noise. What yields against its load, or is of a size that it has
    on no machine, is none of the causes, though something is there: it has no name, and goes where they do
    without it. Nor is one that does what it does by what stands beside its form alone."""
    left = max(1.0, remainder(selection.fit, noise_known).inflation)
    against = frozenset(
        effect.key for effect, own in selection.groups if _against_physics(selection.fit, own, left)
    )
    selection = replace(selection, faint=selection.faint | against, against=against)
    fit, beside = selection.fit, _beside(selection)
    if not beside:
        return selection
    effects = [effect for effect in fit.model.effects if effect.key not in against]
    alone = refit(replace(fit, noise=noise) if noise_known else fit, effects, ROUGH)
    if noise_known and not remainder(alone, noise_known).scatter:
        return selection
    whole = refit(alone, [*effects, *beside], ROUGH)
    if noise_known:
        whole = replace(whole, noise=with_scatter(whole, noise))
    whole = refit(whole, whole.model.effects)
    error, better = rms_mm(heldout(whole, seed=seed)), 1 / BETTER if against else BETTER
    if error > better * rms_mm(heldout(fit, seed=seed)):
        return selection
    off = set(beside.values())
    beside_it = frozenset(key for key in off if of_itself(whole, key) < SURELY**2)
    found = replace(selection, fit=whole, beside=beside, against=frozenset())
    gains_mm = {e.key: without(whole, own, seed) - error for e, own in found.groups if e.key in off}
    found = replace(found, gains_mm={**selection.gains_mm, **gains_mm})
    return replace(found, faint=found.faint | beside_it, against=beside_it)


def of_itself(fit: Fit, key: Key) -> float:
    """What a cause's own numbers are in a fit, without what stands beside its form: squared, in standard
    deviations."""
    return max(fit.wald(i) for i, effect in enumerate(fit.model.effects) if effect.key == key)


def _against_physics(fit: Fit, own: Sequence[int], left: float) -> bool:
    """Whether one of a fit's effects is a spring that gives less than nothing, the model's part too, or has a
    number surely outside the bounds that hold for it. left: what the fit leaves, over its noise."""
    for i in own:
        effect = fit.model.effects[i]
        values, covariance = fit.effect_values(i)
        doubt = SURELY * left * np.sqrt(np.diag(covariance))
        lower, upper = np.array([(p.lower, p.upper) for p in effect.params]).T
        bounded = effect.bounded or effect.acts == "yielding"
        if bounded and ((values + doubt < lower) | (values - doubt > upper)).any():
            return True
    return False


def _beside(selection: Selection) -> dict[Effect, Key]:
    """What stands beside the named causes' forms without a name of its own, in the scale in which these were
    likeliest, and whose it is; not what the model has already."""
    fit = selection.fit
    scales = [(selection.components[m.component].key, m.scale) for m in selection.members]
    scale = {bare(key): own for key, own in scales} | dict(scales)  # of two lines of a joint each its own
    named = [fit.model.effects[i] for _, own in selection.groups for i in own]
    scaled = [(one, scale.get((one.cause, one.where), scale[one.key])) for one in named]
    return beside_forms(scaled, fit.model.problem, fit.model.effects)
