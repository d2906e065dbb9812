"""What makes a cause visible: the residual along the effect's own direction, against its variable."""

from __future__ import annotations

import numpy as np

from ..effects.base import Effect
from ..identification.fit import Fit
from ..robot.kinematics import Array
from .families import Family
from .result import Evidence

FAINTEST = 1e-6  # share of its largest size below which an effect says nothing of a pose
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


def structure_evidence(result: Fit, family: Family) -> Evidence:
    """The residual's part that a function without a name takes, against its variable."""
    flat = family.columns.reshape(-1, family.columns.shape[2])
    scale = np.linalg.norm(flat, axis=0) + 1e-300
    solution = np.linalg.lstsq(flat / scale, result.r.ravel(), rcond=1e-8)[0]
    explained = ((flat / scale) @ solution).reshape(result.r.shape)
    sigma = float(np.sqrt(np.mean(result.noise.sigma**2))) * 1e3
    if family.joint is not None:
        problem = result.model.problem
        column = int(problem.arm.axial[family.joint])
        g = np.matmul(result.whitener, result.line.direct[:, :, column, None])[..., 0]
        strength = np.maximum((g**2).sum(axis=1), 1e-3 * np.median((g**2).sum(axis=1)))
        before = (g * result.r).sum(axis=1) / strength * 1e6
        part = (g * explained).sum(axis=1) / strength * 1e6
        unit, name = "µrad", f"error of {problem.arm.names[family.joint]}"
    else:
        length = np.maximum(np.linalg.norm(explained, axis=1), 1e-12)
        part = length * sigma
        before = (explained * result.r).sum(axis=1) / length * sigma
        unit, name = "mm", "error along the structure"
    turn = 180 / np.pi if family.unit == "rad" else 1.0
    order = np.argsort(family.x)
    return Evidence(
        family.variable,
        "deg" if family.unit == "rad" else family.unit,
        name,
        unit,
        family.x * turn,
        before,
        before - part,
        family.x[order] * turn,
        part[order],
    )
