"""What makes a cause visible: the residual along the effect's own direction, against its variable."""

from __future__ import annotations

import numpy as np

from ...effects.base import Effect
from ...effects.unnamed import Unnamed
from ...identification.fit import Fit
from ...robot.kinematics import Array
from ..found import Evidence

FAINTEST = 1e-6  # share of its largest size below which an effect says nothing of a pose
CURVE = 40  # points of the curve of a function without a name, each a mean over poses near by
WEAKEST = 0.02  # share of the median pose's strength below which a pose says nothing of an effect


def evidence(result: Fit, effect: Effect, values: Array) -> Evidence:
    """Evidence of an effect of a fitted model, over what the effect says that it depends on.

    Each pose tells how much of the effect it shows: the residual along what the effect does there, over
    that. Before: the final residual plus the effect; after: the final residual. Poses where it hardly shows
    are left out.
    """
    problem, model = result.model.problem, result.model
    drawn = effect.drawn(problem, result.line.prediction, values)
    moved = model.effect_jacobian(result.line, effect, values) @ values
    moved = np.matmul(result.whitener, moved[..., None])[..., 0]
    there = np.abs(drawn.size) > FAINTEST * np.abs(drawn.size).max(initial=0.0)
    unit = moved / np.where(there, drawn.size, 1.0)[:, None]
    strength = (unit**2).sum(axis=1)
    shown = there & (strength > 0)
    shown &= strength > WEAKEST * np.median(strength[shown]) if shown.any() else shown
    after = (unit * result.r).sum(axis=1)[shown] / strength[shown]
    x, y = drawn.line
    return Evidence(
        drawn.x_name,
        drawn.x_unit,
        drawn.name,
        drawn.unit,
        drawn.x[shown],
        after + drawn.size[shown],
        after,
        x,
        y,
    )


def structure_evidence(result: Fit, function: Unnamed) -> Evidence:
    """The part of the data that a function without a name takes beyond geometry, frames and targets, against
    its variable; its sign is that along the direction in which it moves most."""
    problem = result.model.problem
    moved, data = _taken(result, function)
    sigma = result.usual * 1e3
    length = np.maximum(np.linalg.norm(moved, axis=1), 1e-12)
    main = np.linalg.svd(moved, full_matrices=False)[2][0]
    along = np.where(moved @ main < 0, -1.0, 1.0)
    part, before = (along * (moved * of).sum(axis=1) / length * sigma for of in (moved, data))
    turn, unit = (np.degrees(1.0), "deg") if function.unit == "rad" else (1.0, function.unit)
    x = function.x(problem) * turn
    near = np.array_split(np.argsort(x), max(min(CURVE, len(x) // 5), 1))
    curve = np.array([(x[some].mean(), part[some].mean()) for some in near])
    return Evidence(
        function.variable, unit, "error along the structure", "mm", x, before, before - part, *curve.T
    )


def _taken(result: Fit, function: Unnamed) -> tuple[Array, Array]:
    """(N, D) whitened: what a function takes of the data, and the data without everything else."""
    for effect, values in zip(result.model.effects, result.state.values, strict=True):
        if effect == function:
            G = result.model.effect_jacobian(result.line, effect, values)
            moved = result.beyond_background(np.matmul(result.whitener, (G @ values)[..., None])[..., 0])
            return moved, result.r + moved
    flat = result.whitened(function).reshape(result.r.size, -1)
    scale = np.linalg.norm(flat, axis=0) + 1e-300
    solution = np.linalg.lstsq(flat / scale, result.r.ravel(), rcond=1e-8)[0]
    return result.beyond_background(((flat / scale) @ solution).reshape(result.r.shape)), result.r
