"""Loads that show in the points only through what gives way to them in the fit.

At a fit in which a joint or a bearing yields, a load that is wrong moves the points by that yield. Where
nothing else yields to it, it is no rival of the yield: without that it would move nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..identification.fit import Fit
from .components import Component, bare

LEFT = 0.3  # of the length of its columns without the yield: what keeps less lives by it

Needs = Mapping[int, frozenset[int]]


def needs_of(fit: Fit, components: Sequence[Component]) -> Needs:
    """Of each load's component, by its number: those of the fitted yields without which it moves nothing."""
    number = {bare(component.key): k for k, component in enumerate(components)}
    fitted = [
        (number[effect.key], effect, values)
        for effect, values in zip(fit.model.effects, fit.state.values, strict=True)
        if effect.acts == "yielding" and effect.key in number
    ]
    found = dict[int, frozenset[int]]()
    for k, component in enumerate(components if fitted else ()):
        form = component.forms[0]
        load = form.effects[0]
        wrench = load.pulled(fit.model.problem, fit.line)
        if wrench is None:
            continue
        whole, live = form.patterns[0].columns, set[int]()
        for own, effect, values in fitted:
            by_it = effect.yields_to(fit.line, wrench, values)
            if by_it is not None:
                without = whole - np.matmul(fit.whitener, by_it)
                if np.linalg.norm(without) < LEFT * np.linalg.norm(whole):
                    live.add(own)
        if live:
            found[k] = frozenset(live)
    return found
