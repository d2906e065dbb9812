"""What takes the place of a cause that its own numbers refute: a spring that would push back, a form that
does nothing by itself."""

from __future__ import annotations

from collections.abc import Sequence

from ...effects.base import Effect
from ...identification.heldout import heldout
from ..prepared import Prepared
from .competition import Selection, compete
from .off_form import with_own_forms
from .stages import rms_mm
from .worth import VOUCHED, no_surer, worth_it

NEARLY = 0.9  # of what a set with refuted causes brings, that one without them has to


def with_none_refuted(
    prepared: Prepared, selection: Selection, candidates: Sequence[Effect], seed: int
) -> Selection:
    """The selection, its causes judged by what they are beside their forms too (`with_own_forms`). Where one
    of them is none by that, the likeliest set without it, if that has no more causes, and brings nearly as
    much on poses held out: the data like a form of one cause better than the forms that are known of another.
    What is named there alone is no surer than by four parts of the data that agree."""
    found = _judged(prepared, selection, seed)
    if not found.against:
        return found
    left = [effect for effect in candidates if effect.key not in found.against]
    other = _judged(prepared, compete(prepared, left), seed)
    if other.against or len(other.groups) > len(found.groups) + len(found.against):
        return found
    before, refuted, without = (
        rms_mm(heldout(fit, seed=seed)) for fit in (prepared.geometry, found.fit, other.fit)
    )
    if before - without < NEARLY * (before - refuted):
        return found
    had = {effect.key for effect, _ in found.groups}
    return no_surer(other, {effect.key: VOUCHED for effect, _ in other.groups if effect.key not in had})


def _judged(prepared: Prepared, selection: Selection, seed: int) -> Selection:
    return with_own_forms(worth_it(selection, seed), prepared.covariance, prepared.noise_known, seed)
