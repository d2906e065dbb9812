"""Loads that show in the points only by what gives way to them in the fit, and what gives way only to them.

At a fit in which a joint or a bearing yields, a load that is wrong moves the points by that yield. Where
nothing else yields to it, it is no rival of the yield: without that it would move nothing. Nor is a joint
that yields a rival of the load in the fit which is nearly all that there is on it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..effects.base import Effect
from ..identification.fit import Fit
from ..robot.kinematics import Array
from .components import Component, bare

LEFT = 0.3  # of the length of its columns without the other: what keeps less lives by it

Needs = Mapping[int, frozenset[int]]
Fitted = Sequence[tuple[int, Effect, Array]]  # number of its component, effect, values


def needs_of(fit: Fit, components: Sequence[Component]) -> Needs:
    """Of the components, by their number, those of what is fitted without which they move nothing."""
    number = {bare(component.key): k for k, component in enumerate(components)}
    fitted = [
        (number[effect.key], effect, values)
        for effect, values in zip(fit.model.effects, fit.state.values, strict=True)
        if effect.key in number
    ]
    found = dict[int, frozenset[int]]()
    for k, component in enumerate(components if fitted else ()):
        pattern = component.forms[0].patterns[0].columns
        least = LEFT * float(np.linalg.norm(pattern))
        lives_by = {
            own
            for own, part in _by_each(fit, component.forms[0].effects[0], fitted)
            if own != k and np.linalg.norm(pattern - np.matmul(fit.whitener, part)) < least
        }
        if lives_by:
            found[k] = frozenset(lives_by)
    return found


def _by_each(fit: Fit, effect: Effect, fitted: Fitted) -> Iterator[tuple[int, Array]]:
    """Motions (N, R, p) that are due to one of what is fitted: of a load by yields, of a yield by loads."""
    problem, line = fit.model.problem, fit.line
    wrench, local = effect.pulled(problem, line), line.prediction.load.local
    nothing = np.zeros(len(effect.params))
    for own, other, values in fitted:
        pulled = other.pulled(problem, line)
        if wrench is not None:
            moved = other.yields_to(line, wrench, values)
        elif pulled is not None and (whole := effect.under(line, local, nothing)) is not None:
            without = effect.under(line, local - pulled @ values, nothing)
            moved = None if without is None else whole - without
        else:
            continue
        if moved is not None:
            yield own, moved
