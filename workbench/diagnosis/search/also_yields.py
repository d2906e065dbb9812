"""The rest of an arm that yields in several places: all of it does.

Where an arm was found to yield in several places, these are often not a few faults: it yields everywhere a
little, most of it too little to be found place by place. What that does goes into the places that were found,
two springs into one, and makes of their sizes what they are not. So the others stand in the fit as well,
without a name, each held by a prior as wide as those are large that were found: ridge regression (Hoerl &
Kennard 1970) with a ridge that the data set (empirical Bayes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...effects.base import Effect
from ...identification.fit import ROUGH, TOLERANCE, Fit, refit
from ...identification.heldout import heldout
from ...identification.noise import Covariance
from ...robot.kinematics import RX
from ..noise.scatter import with_scatter
from ..priors import PRIORS
from ..weighing.components import Key, bare, is_alike, usual
from ..weighing.stand_ins import SURELY
from .competition import Selection
from .off_form import of_itself
from .rounds import BETTER
from .stages import rms_mm
from .worth import VOUCHED, no_surer

MANY = 3  # places that were found to yield: not a few faults, but an arm that yields


def with_what_also_yields(
    selection: Selection, candidates: Sequence[Effect], noise: Covariance, noise_known: bool, seed: int
) -> Selection:
    """The selection with all candidates that yield in the fit, where poses held out are predicted better with
    them, or no worse where many were found; no place is named then that the data do not tell from these.
    noise: without the scatter that the search took for noise."""
    fit = selection.fit
    found = [i for i, effect in enumerate(fit.model.effects) if effect.in_proportion]
    others = _others(fit, found, candidates)
    if not others:
        return selection
    whole = _giving(fit, others, ROUGH)
    if noise_known:
        whole = replace(whole, noise=with_scatter(whole, noise))
    whole = _giving(whole, [effect for effect in whole.model.effects if effect.is_held], TOLERANCE)
    error, before = (rms_mm(heldout(one, seed=seed)) for one in (whole, fit))
    wanted = BETTER if len(found) < MANY else 1 / BETTER
    return _as_sure_as_beside(replace(selection, fit=whole)) if error < wanted * before else selection


def _as_sure_as_beside(selection: Selection) -> Selection:
    """No yield named for sure that the data do not tell from what yields beside it, most of all from what
    goes with it closest."""
    fit, surest, instead = selection.fit, dict[Key, float](), dict[Key, int]()
    components = {bare(component.key): k for k, component in enumerate(selection.components)}
    held = [i for i, effect in enumerate(fit.model.effects) if effect.is_held]
    for effect, own in selection.groups:
        if effect.in_proportion and of_itself(fit, effect.key) < SURELY**2:
            closest = max(held, key=lambda i: _correlation(fit, own[0], i), default=None)
            surest[effect.key] = VOUCHED
            if closest is not None and (key := fit.model.effects[closest].key) in components:
                instead[effect.key] = components[key]
    return no_surer(selection, surest, instead)


def _correlation(fit: Fit, i: int, j: int) -> float:
    """Size of the correlation of the first numbers of two effects."""
    a, b = (fit.columns.effect[k].start for k in (i, j))
    return float(abs(fit.covariance[a, b]) / np.sqrt(fit.covariance[a, a] * fit.covariance[b, b]))


def _giving(fit: Fit, others: Sequence[Effect], tolerance: float) -> Fit:
    """With those of the others in the fit that give under their load, not against it."""
    effects = [effect for effect in fit.model.effects if effect not in others]
    while True:
        whole = refit(fit, [*effects, *others], tolerance)
        against = [
            effect
            for i, effect in enumerate(whole.model.effects)
            if effect in others and whole.effect_values(i)[0][0] < effect.params[0].lower
        ]
        if not against:
            return whole
        others = [effect for effect in others if effect not in against]


def _others(fit: Fit, found: Sequence[int], candidates: Sequence[Effect]) -> list[Effect]:
    """The candidates that yield and are not in the fit, each held to the size of those that were found, in
    their usual sizes; none where none was."""
    sizes = [fit.effect_values(i)[0] / _as_built(fit, fit.model.effects[i]) for i in found]
    size = float(np.sqrt(np.mean(np.square(sizes)))) if found else 0.0
    there, others = {effect.key for effect in fit.model.effects}, dict[Key, Effect]()
    for effect in candidates:
        # not all joints alike: each is here by itself
        if effect.in_proportion and not is_alike(effect) and effect.key not in there:
            others.setdefault(effect.key, replace(effect, held=size * _as_built(fit, effect)))
    return list(others.values()) if size > 0 else []


def _as_built(fit: Fit, effect: Effect) -> float:
    """The usual size of a yield's number. A joint is built for all that it carries, about whatever axis: an
    upright one, which these loads hardly turn, is no softer for that, and yields to other loads."""
    size, problem = float(usual(fit, effect)[0]), fit.model.problem
    if effect.stated or not effect.axial:
        return size
    j = problem.joint(effect.where.joint)
    load = fit.line.prediction.load.local[:, j + 1]
    own = load[:, :RX] if problem.arm.prismatic[j] else load[:, RX:]
    borne = float(np.linalg.norm(own, axis=1).max(initial=0.0))
    return min(size, PRIORS.joint_yields * problem.coarse / borne) if borne else size
