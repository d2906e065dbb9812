"""The numbers of a change as people know them: by how much, and from what to what."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...effects.base import Effect
from ...effects.place import Parameter
from ...robot.kinematics import Array
from ..search.rounds import LOOSE
from .candidates import Shape, numbers_of_shape
from .decision import Decided
from .found import PHASE
from .levels import Levels

Numbers = tuple[Parameter, ...]
HELD = 0.5  # of the standard deviation that a number has without data
KNOWN = 0.5  # rad: a phase is known that is surer than this
STEP = 1e-3  # of a standard deviation: of a derivative


def parameters_of(shape: Shape, mean: Array, covariance: Array) -> Numbers:
    """The main numbers, from those in prior sizes; of an effect as it reports them itself, of the geometry
    those that the data show: not what another number does as well and its prior alone holds."""
    main = shape.main
    value = mean[:main] * shape.sizes[:main]
    C = covariance[:main, :main] * np.outer(shape.sizes[:main], shape.sizes[:main])
    if len(shape.effects) == 1 and not shape.named:
        return shape.effects[0].report(value, C)
    names, std = numbers_of_shape(shape), np.sqrt(np.diag(C))
    shown = std < max(HELD * LOOSE * float(shape.sizes[0]), 1.001 * float(std.min()))
    return tuple(
        Parameter("zero" if shape.zero else name, float(v), float(s), unit)
        for (name, unit), v, s, own in zip(names, value, std, shown, strict=True)
        if own
    )


def numbers_at(decided: Decided, levels: Levels, k: int) -> tuple[Numbers, Numbers, Numbers]:
    """By how much the numbers changed up to an occasion; and before and after, where all campaigns have the
    effect and its numbers do not add up: a difference's amplitude is none of amplitudes."""
    shape, system, solved = levels.shape, decided.system, decided.solved
    result = system.occasions[0].fit
    known = [e for e in shape.effects if e in result.model.effects]
    own = parameters_of(shape, *levels.at(k))
    if len(shape.effects) > 1 or not known or shape.named:
        return own, (), ()
    part = result.columns.effect[result.model.effects.index(known[0])]
    start = system.common.start - result.columns.geometry_slice.start
    rows = slice(start + part.start, start + part.stop)
    value = solved.values[rows] * system.prior[rows]
    half = solved.factor * levels.all_numbers[rows] * system.prior[rows, None]
    main, sizes = shape.main, shape.sizes[: shape.main]
    more, more_half = levels.mean[k, :main] * sizes, levels.half[k, :main] * sizes[:, None]
    last = half + more_half
    before, after = known[0].report(value, half @ half.T), known[0].report(value + more, last @ last.T)
    add_up = [p.name for p in before] == [p.name for p in known[0].params]
    if add_up or len(before) != main:  # one size of a whole function says nothing of its form
        return own, (), ()
    by = zip(*_difference(known[0], value, more, np.vstack([half, more_half])), strict=True)
    changed = [replace(p, value=v, std=s) for p, (v, s) in zip(before, by, strict=True)]
    if own[0].std < HELD * changed[0].std:  # what was there before is not known so well
        return own, (), ()
    said = [
        one
        for one in zip(changed, before, after, strict=True)
        if one[0].name != PHASE or max(one[1].std, one[2].std) < KNOWN
    ]
    changed_, before, after = zip(*said, strict=True)
    return changed_, before, after


def _difference(effect: Effect, value: Array, more: Array, half: Array) -> tuple[list[float], list[float]]:
    """Of reported numbers after minus before, and one sigma each. half: (2p, ·) of value and more (p,)."""
    names = [p.name for p in effect.report(value, np.eye(len(value)))]

    def by(x: Array) -> Array:
        first, last = (
            np.array([p.value for p in effect.report(v, np.eye(len(v)))])
            for v in (x[: len(value)], x[: len(value)] + x[len(value) :])
        )
        return np.array([_short(n, d) for n, d in zip(names, last - first, strict=True)])

    at = np.concatenate([value, more])
    each = STEP * np.linalg.norm(half, axis=1)
    each[each == 0] = STEP * max(float(np.abs(at).max()), 1e-12)
    slopes = []
    for i, size in enumerate(each):
        step = size * (np.arange(len(at)) == i)
        difference = [_short(n, d) for n, d in zip(names, by(at + step) - by(at - step), strict=True)]
        slopes.append(np.array(difference) / (2 * size))
    return by(at).tolist(), np.linalg.norm(np.array(slopes).T @ half, axis=1).tolist()


def _short(name: str, difference: float) -> float:
    """A difference the short way round."""
    return math.remainder(difference, 2 * math.pi) if name == PHASE else float(difference)
