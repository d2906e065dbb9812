"""Loads that show in the points only by what gives way to them in the fit, and what gives way only to them.

At a fit in which a joint or a bearing yields, a load that is wrong moves the points by that yield. Where
nothing else yields to it, it is no rival of the yield: without that it would move nothing. Nor is a joint
that yields a rival of the load in the fit which is nearly all that there is on it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ...effects.base import Effect
from ...identification.fit import Fit
from ...identification.patterns import Pattern
from ...robot.kinematics import Array
from .components import Component, bare

LEFT = 0.3  # of the length of its columns without the other: what keeps less lives by it

Needs = Mapping[int, frozenset[int]]
Yields = Sequence[tuple[int, Effect, Array]]  # number of its component, effect, values
Loads = Sequence[tuple[int, Array]]  # number of its component, local wrenches (N, S, 6)


def needs_of(fit: Fit, components: Sequence[Component]) -> Needs:
    """Of the components, by their number, those of what is fitted without which they move nothing."""
    number = {bare(component.key): k for k, component in enumerate(components)}
    yields, loads = list[tuple[int, Effect, Array]](), list[tuple[int, Array]]()
    for effect, values in zip(fit.model.effects, fit.state.values, strict=True):
        if effect.key not in number:
            continue
        pulled = effect.pulled(fit.model.problem, fit.line)
        if pulled is not None:
            loads.append((number[effect.key], pulled @ values))
        elif effect.acts == "yielding":
            yields.append((number[effect.key], effect, values))
    found = dict[int, frozenset[int]]()
    for k, component in enumerate(components if yields or loads else ()):
        effect, pattern = component.forms[0].effects[0], component.forms[0].patterns[0]
        lives_by = {
            own
            for own, left in _left_without(fit, effect, pattern, yields, loads)
            if own != k and np.linalg.norm(left) < LEFT * np.linalg.norm(pattern.columns)
        }
        if lives_by:
            found[k] = frozenset(lives_by)
    return found


def _left_without(
    fit: Fit, effect: Effect, pattern: Pattern, yields: Yields, loads: Loads
) -> Iterator[tuple[int, Array]]:
    """(N, D, p) what is left of an effect's pattern without one of what is fitted: of a load's without a
    yield, of a yield's without a load."""
    line = fit.line
    wrench = effect.pulled(fit.model.problem, line)
    if wrench is not None:
        for own, other, values in yields:
            by_it = other.yields_to(line, wrench, values)
            if by_it is not None:
                yield own, pattern.columns - np.matmul(fit.whitener, by_it)
        return
    for own, by_load in loads:
        moved = effect.under(line, line.prediction.load.local - by_load, np.zeros(len(effect.params)))
        if moved is not None:
            yield own, np.matmul(fit.whitener, moved)
