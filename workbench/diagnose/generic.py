"""Families without a name: does the residual depend on a joint, two joints, torque, time, approach?

They give power against causes that are not in the catalogue, and say what an unknown one depends on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arm import RX, RY, Array
from ..fit import Fit
from .screen import quadratic, reduce_columns


@dataclass(frozen=True)
class Family:
    """A named group of whitened columns (N, D, g). `variable` for people, `x`: (N,) to plot against."""

    variable: str
    unit: str
    columns: Array
    x: Array
    joint: int | None = None


@dataclass(frozen=True)
class FamilyTest:
    family: Family
    statistic: float
    rank: int


def families(fit: Fit) -> Iterator[Family]:
    """All families that the campaign's columns allow."""
    problem = fit.model.problem
    arm, q = problem.arm, problem.q
    moves = [np.matmul(fit.whitener, fit.line.direct[:, :, int(k), None]) for k in arm.axial]
    angle = [np.where(arm.prismatic[j], 3.0, 1.0) * q[:, j] for j in range(arm.n)]
    for j in range(arm.n):
        if np.ptp(q[:, j]) < 1e-3:
            continue
        slot = j + 1
        tilt = [np.matmul(fit.whitener, fit.line.direct[:, :, 6 * slot + k, None]) for k in (RX, RY)]
        waves = np.column_stack([f(k * angle[j]) for k in (1, 2, 3, 4) for f in (np.sin, np.cos)])
        own = _times(moves[j], np.column_stack([angle[j], angle[j] ** 2, waves]))
        other = [_times(t, waves[:, :4]) for t in tilt]
        yield Family(arm.names[j], "rad", np.concatenate([own, *other], axis=2), q[:, j], j)
    for i in range(arm.n):
        for j in range(arm.n):
            if i == j or min(np.ptp(q[:, i]), np.ptp(q[:, j])) < 1e-3:
                continue
            si, ci, sj, cj = np.sin(angle[i]), np.cos(angle[i]), np.sin(angle[j]), np.cos(angle[j])
            mixed = np.column_stack([angle[j], sj, cj, si * sj, si * cj, ci * sj, ci * cj])
            yield Family(f"{arm.names[i]} with {arm.names[j]}", "rad", _times(moves[i], mixed), q[:, j])
    yield from _other_families(fit, moves)


def _other_families(fit: Fit, moves: list[Array]) -> Iterator[Family]:
    problem = fit.model.problem
    c, arm = problem.campaign, problem.arm
    torque = fit.line.prediction.load.local.reshape(len(c.q), -1)[:, arm.axial]
    for j in range(arm.n):
        size = np.abs(torque[:, j]).max()
        if np.ptp(torque[:, j]) > 1e-3 * max(size, 1.0):
            x = torque[:, j] / size
            bent = np.column_stack([x, x**2, x**3, np.tanh(10 * x), np.abs(x)])
            yield Family(f"torque of {arm.names[j]}", "N·m", _times(moves[j], bent), torque[:, j], j)
    base = np.matmul(fit.whitener, fit.line.direct[:, :, :6])
    order = np.linspace(-1, 1, len(c.q))
    if c.time is not None and np.isfinite(c.time).all() and np.ptp(c.time) > 0:
        order = 2 * (c.time - c.time.min()) / np.ptp(c.time) - 1
        yield Family("time", "s", _times(base, np.column_stack([order, order**2, order**3])), c.time)
    else:
        yield Family("order of measurement", "1", _times(base, np.column_stack([order, order**2])), order)
    if c.temperature is not None and np.isfinite(c.temperature).all() and np.ptp(c.temperature) > 0:
        warm = c.temperature - c.temperature.mean()
        yield Family("temperature", "°C", _times(base, warm[:, None]), c.temperature)
    if c.direction is not None:
        for j in range(arm.n):
            if np.ptp(c.direction[:, j]) > 0:
                side = c.direction[:, j]
                form = np.column_stack([side, side * np.sin(c.q[:, j]), side * np.cos(c.q[:, j])])
                yield Family(f"approach of {arm.names[j]}", "1", _times(moves[j], form), side, j)
    flange = np.matmul(fit.whitener, fit.line.direct[:, :, 6 * (arm.n + 1) :])
    present = [i for i in range(len(c.payload_names)) if (c.payload == i).any()]
    if len(present) > 1:
        which = np.column_stack([(c.payload == i).astype(float) for i in present[1:]])
        yield Family("payload", "1", _times(flange, which), c.payload.astype(float))


def _times(move: Array, functions: Array) -> Array:
    """(N, D, a·b): every motion (N, D, a) with every function (N, b)."""
    n_poses, rows = move.shape[:2]
    return np.asarray(move[..., None] * functions[:, None, None, :]).reshape(n_poses, rows, -1)


def test_families(fit: Fit) -> list[FamilyTest]:
    """Statistic and rank of every family at a fit."""
    out = []
    for family in families(fit):
        S, u, own = reduce_columns(fit, family.columns)
        out.append(FamilyTest(family, *quadratic(S, u, np.maximum(own, 1e-12 * own.max() + 1e-300))))
    return out


test_families.__test__ = False  # type: ignore[attr-defined]  # not a pytest function
