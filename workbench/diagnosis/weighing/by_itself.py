"""Whether a component shows at a fit at all: what does not need not compete, which takes time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ...identification.fit import Fit
from ..priors import PRIORS
from .chosen import Chosen
from .components import Component
from .forms import Forms
from .gram import Stored
from .reduced import Reduced, slices_of
from .screen import effective_dof, reduce_columns


def worth_offering(fit: Fit, components: Iterable[Component], noise_dof: float) -> Iterator[Component]:
    """Components without those of the instrument's own errors that neither show beside what a fit has nor are
    in it, in whatever size."""
    kept = {(type(effect), effect.where) for effect in fit.model.effects}
    for one in components:
        effect = one.effect
        own = effect is not None and effect.acts == "instrument" and (type(effect), effect.where) not in kept
        if not own or shows_by_itself(fit, one, noise_dof):
            yield one


def shows_by_itself(fit: Fit, component: Component, noise_dof: float) -> bool:
    """Whether a component, beside what a fit has, is likelier than a rival that is not worth a word."""
    form = component.forms[0]
    S, u, _ = reduce_columns(fit, form.columns * form.sizes)
    gram = Stored(S, np.arange(len(u)), np.ones(len(u)))
    left = Reduced(slices_of([component]), gram, u, fit.chi2, effective_dof(fit), noise_dof)
    (weight,) = Forms(left, [component]).weigh(Chosen(left, []), [0])
    return weight.log_odds > np.log(PRIORS.faintest_rival)
