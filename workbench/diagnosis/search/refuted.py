"""What takes the place of a cause that its own numbers refute: a spring that would push back, a form that
does nothing by itself."""

from __future__ import annotations

from collections.abc import Sequence

from ...effects.base import Effect
from ...identification.heldout import heldout
from ..prepared import Prepared
from .also_yields import with_what_also_yields
from .competition import Selection, compete
from .off_form import with_own_forms
from .stages import rms_mm
from .worth import VOUCHED, no_surer, worth_it

NEARLY = 0.9  # of what a set with refuted causes brings, that one without them has to


def with_none_refuted(
    prepared: Prepared, found: Selection, candidates: Sequence[Effect], seed: int
) -> Selection:
    """The selection; where its causes' own numbers refute one of them, the likeliest without it, if that has
    no more causes, and brings nearly as much on poses held out: the data like a form of one cause better than
    the forms that are known of another. What is named there alone is no surer than by four parts of the data
    that agree."""
    if not found.against:
        return found
    left = [effect for effect in candidates if effect.key not in found.against]
    other = judged(prepared, compete(prepared, left), candidates, seed)
    if other.against or len(other.groups) > len(found.groups) + len(found.against):
        return found
    before, refuted, without = (
        rms_mm(heldout(fit, seed=seed)) for fit in (prepared.geometry, found.fit, other.fit)
    )
    if before - without < NEARLY * (before - refuted):
        return found
    had = {effect.key for effect, _ in found.groups}
    return no_surer(other, {effect.key: VOUCHED for effect, _ in other.groups if effect.key not in had})


def judged(prepared: Prepared, selection: Selection, candidates: Sequence[Effect], seed: int) -> Selection:
    """A selection by what it brings, by what its causes are beside their forms, and with what yields too."""
    noise, known = prepared.covariance, prepared.noise_known
    selection = with_own_forms(worth_it(selection, known, seed), noise, known, seed)
    return with_what_also_yields(selection, candidates, noise, known, seed)
