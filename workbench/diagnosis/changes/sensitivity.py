"""What did not change, and what could have been seen of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.special import logsumexp
from scipy.stats import norm

from ...effects.place import Parameter
from ...identification.patterns import Products
from ...robot.kinematics import Array
from ..priors import PRIORS
from ..search.rounds import LOOSE
from ..telling.power import MANY, POWER
from ..weighing.reduced import without_background
from ..weighing.weight import SCALES, WEIGHTS
from .candidates import Candidate, Shape, moved, numbers_of_shape
from .covered import carried_change
from .decision import Decided, form_of
from .found import Unchanged
from .system import System, solve

GRID = np.linspace(1.0, 15.0, 281)  # standard deviations
DRAWS = 500
SEEN = 0.95


def unchanged(decided: Decided) -> Iterator[Unchanged]:
    """Every number that no member has, at the last campaign against those before."""
    taken = {decided.candidates[m.component].quantity for m in decided.members} | decided.mute
    last = decided.system.last
    found = [decided.shape(m).columns for m in decided.members]
    for k, candidate in enumerate(decided.candidates):
        if not candidate.change or candidate.quantity in taken:
            continue
        for shape, part in zip(candidate.shapes, decided.reduced.parts[k], strict=True):
            if shape.is_at(last) and (shape.main == 1 or not shape.geometry):
                yield from _unchanged(decided, candidate, shape, part, found)


def _unchanged(
    decided: Decided, candidate: Candidate, shape: Shape, part: slice, found: Sequence[Array]
) -> Iterator[Unchanged]:
    """found: columns of the members. The weights of a free function are nobody's numbers."""
    if shape.free or shape.main >= MANY or len(shape.sizes) == 0:
        return
    index = np.arange(part.start, part.start + shape.main)
    S, u = (x[0] for x in decided.chosen.left_of(index[None]))
    held = S + LOOSE**-2 * np.eye(len(S))
    value, covariance = np.linalg.solve(held, u), np.linalg.inv(held)
    factor = decided.factor(shape.pattern)
    value, std = (
        value * shape.sizes[: shape.main],
        factor * np.sqrt(np.diag(covariance)) * shape.sizes[: shape.main],
    )
    values, vectors = np.linalg.eigh(S)
    if values[0] * LOOSE**2 < 1.0:
        return
    z = threshold(candidate, float(values[0])) + float(norm.isf(1 - POWER))
    weakest = factor * z / np.sqrt(values[0]) * vectors[:, 0]
    mm = seen_mm(decided.system, shape.columns[:, : shape.main], weakest, shape.pattern[:, 0], found)
    name, unit = numbers_of_shape(shape)[0]
    size = float(np.linalg.norm(weakest)) * float(shape.sizes[0])
    number = Parameter(name, float(value[0]), float(std[0]), unit)
    yield Unchanged(
        form_of(candidate, shape), candidate.cause, candidate.where, candidate.side, number, size, mm
    )


def threshold(candidate: Candidate, S: float) -> float:
    """Standard deviations from which a change of one number with information S (in prior sizes) is seen."""
    need = np.log(PRIORS.named / (1 - PRIORS.named)) - candidate.log_odds + np.log(len(candidate.shapes))
    gain = 0.5 * GRID[:, None] ** 2 / (1 + 1 / (SCALES**2 * S)) - 0.5 * np.log1p(SCALES**2 * S) + WEIGHTS
    enough = logsumexp(gain, axis=1) >= need
    return float(GRID[int(np.argmax(enough))]) if enough.any() else float(GRID[-1])


def seen_mm(system: System, columns: Array, size: Array, pattern: Array, more: Sequence[Array]) -> float:
    """RMS [mm] of what columns (R, p) in a size (p,) make of the points of the occasions that have it, once
    frames and targets are fitted anew, and what else (`more`) was found."""
    S = _beside_local(system, columns, more)
    return float(np.sqrt(max(float(size @ S @ size), 0.0))) * _per_root(system, pattern)


def within_mm(decided: Decided) -> float:
    """95 % bound [mm] of what all changes of geometry together make of the points in the poses of all
    campaigns, as far as neither frames and targets nor the members do the same: of few poses, what they do
    not show is much in others."""
    system, last = decided.system, decided.system.last
    geometry = tuple(int(c) for c in system.occasions[0].fit.columns.geometry)
    every = moved(system.occasions, geometry)
    shapes = [decided.shape(m) for m in decided.members]
    solved = solve(system, [*shapes, every.at(last)], [*(m.scale for m in decided.members), LOOSE])
    before = sum(shape.width for shape in shapes)
    mean, covariance = solved.of(slice(before, before + len(geometry)))
    covariance = carried_change(system, last[:, None]) ** 2 * covariance
    S = _beside_local(system, every.base, [shape.base for shape in shapes])
    draws = np.random.default_rng(0).multivariate_normal(mean, covariance, DRAWS, method="svd")
    square = np.asarray(np.einsum("di,ij,dj->d", draws, S, draws), dtype=np.float64)
    length = np.sqrt(np.maximum(square, 0.0))
    return float(np.quantile(length, SEEN)) * system.mm


def nominal_mm(decided: Decided) -> float:
    """[mm] RMS of what the nominal robot is off at the campaign where it is off by most, frame and targets
    fitted."""
    off = [one.prepared.nominal.residual for one in decided.system.occasions]
    return 1e3 * max(float(np.sqrt(np.nanmean((one**2).sum(axis=2)))) for one in off)


def _beside_local(system: System, columns: Array, more: Sequence[Array]) -> Array:
    """What frames and targets (and `more`) leave of columns (R, p): (p, p)."""
    local = np.concatenate([system.J[:, : system.common.start], *(LOOSE * c for c in more)], axis=1)
    zero, nothing = np.zeros(local.shape[1]), np.zeros(len(columns))
    return without_background(local, zero, nothing, 0, Products.of(local, columns, nothing))[0]


def _per_root(system: System, pattern: Array) -> float:
    here = pattern[system.own] > 0
    return system.mm * float(np.sqrt(system.used.sum() / max(system.used[here].sum(), 1)))
