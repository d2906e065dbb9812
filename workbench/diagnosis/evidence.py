"""What makes a cause visible: the residual along the effect's own direction, against its variable."""

from __future__ import annotations

import numpy as np

from ..effects.base import DirectEffect, Effect, TransmissionEffect, YieldEffect
from ..identification.fit import Fit
from ..robot.kinematics import Array
from .families import FamilyTest
from .result import Evidence


def evidence(result: Fit, effect: Effect, values: Array) -> Evidence:
    """Evidence of an effect of a fitted model.

    Before: final residual plus the effect; after: final residual. Joint effects are shown as joint
    angle, others as the error along the direction that the effect predicts.
    """
    problem = result.model.problem
    G = np.matmul(result.whitener, result.model.effect_jacobian(result.line, effect, values))
    added = G @ values
    if isinstance(effect, TransmissionEffect | YieldEffect) and effect.where.joint:
        return _joint(result, effect, values, added)
    r = result.point_residual
    added = added[:, : r.shape[1]]
    size = np.linalg.norm(added, axis=1)
    keep = size > 1e-3 * max(float(size.max()), 1e-300)
    unit = added[keep] / size[keep, None]
    # whitened lengths back to mm by the noise of the pose
    points = 3 * result.residual.shape[1]
    move = (result.model.effect_jacobian(result.line, effect, values) @ values)[keep, :points]
    mm = 1e3 * np.linalg.norm(move, axis=1) / size[keep]
    after = (unit * r[keep]).sum(axis=1) * mm
    x, name, x_unit = size[keep] * mm, "effect predicted", "mm"
    before = after + size[keep] * mm
    time = problem.campaign.time
    if effect.cause in ("drift", "thermal_growth") and time is not None:
        x, name, x_unit = time[keep] / 60, "time", "min"
    order = np.argsort(x)
    curve = size[keep] * mm
    return Evidence(name, x_unit, "error along the effect", "mm", x, before, after, x[order], curve[order])


def _joint(result: Fit, effect: Effect, values: Array, added: Array) -> Evidence:
    problem = result.model.problem
    j = problem.joint(effect.where.joint)
    column = int(problem.arm.axial[j])
    revolute = not problem.arm.prismatic[j]
    g = np.matmul(result.whitener, result.line.direct[:, :, column, None])[..., 0]
    strength = (g**2).sum(axis=1)
    keep = strength > 0.02 * np.median(strength[strength > 0])
    factor, y_unit = (1e6, "µrad") if revolute else (1e6, "µm")
    after = (g * result.r).sum(axis=1)[keep] / strength[keep] * factor
    before = after + (g * added).sum(axis=1)[keep] / strength[keep] * factor
    q = problem.q[keep, j]
    if isinstance(effect, YieldEffect):
        if not revolute or effect.cause not in ("joint_compliance", "lost_motion"):
            size = (g * added).sum(axis=1)[keep] / strength[keep] * factor
            order = np.argsort(size)
            return Evidence(
                "effect predicted",
                y_unit,
                f"error at {effect.where.joint}",
                y_unit,
                size,
                before,
                after,
                size[order],
                size[order],
            )
        wrench = result.line.prediction.load.local[:, j + 1]
        x = result.line.prediction.load.local.reshape(len(g), -1)[keep, column]
        grid = np.linspace(x.min(), x.max(), 200)
        sample = np.zeros((200, 6))
        sample[:, column % 6] = grid
        del wrench
        curve = effect.law(result.line.prediction.arm, sample, values)[0][:, column % 6] * factor
        return Evidence(
            f"torque of {effect.where.joint}",
            "N·m",
            f"error of {effect.where.joint}",
            y_unit,
            x,
            before,
            after,
            grid,
            curve,
        )
    assert isinstance(effect, DirectEffect)
    cycles = effect.where.order
    if cycles is not None:
        x = np.degrees(np.mod(cycles * q, 2 * np.pi))
        grid = np.linspace(0, 360, 200)
        wave = np.column_stack([np.sin(np.radians(grid)), np.cos(np.radians(grid))]) @ values * factor
        return Evidence(
            f"phase of order {cycles:g}",
            "deg",
            f"error of {effect.where.joint}",
            y_unit,
            x,
            before,
            after,
            grid,
            wave,
        )
    if effect.cause == "backlash":
        direction = problem.campaign.direction
        assert direction is not None
        x = direction[keep, j].astype(float)
        grid = np.array([-1.0, 1.0])
        curve = -grid * values[0] * factor
        return Evidence(
            f"side of approach of {effect.where.joint}",
            "1",
            f"error of {effect.where.joint}",
            y_unit,
            x,
            before,
            after,
            grid,
            curve,
        )
    other = problem.joint(effect.where.other) if effect.where.other else j
    turn = 180 / np.pi if not problem.arm.prismatic[other] else 1e3
    x = problem.q[keep, other] * turn
    grid_q = np.tile(problem.q.mean(axis=0), (200, 1))
    grid_q[:, other] = np.linspace(problem.q[:, other].min(), problem.q[:, other].max(), 200)
    assert isinstance(effect, TransmissionEffect)
    curve = effect.basis(grid_q, None, problem.arm.names) @ values * factor
    unit = "deg" if turn < 1e3 else "mm"
    return Evidence(
        problem.arm.names[other],
        unit,
        f"error of {effect.where.joint}",
        y_unit,
        x,
        before,
        after,
        grid_q[:, other] * turn,
        curve,
    )


def structure_evidence(result: Fit, test: FamilyTest) -> Evidence:
    """The residual's part that a generic family takes, against the family's variable."""
    family = test.family
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
