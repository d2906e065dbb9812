"""What constant stiffness cannot take over of an effect of the load: how large it would have to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arm import Array
from ..campaign import Campaign
from ..effects.base import Effect
from ..effects.joint_compliance import JointCompliance
from ..model import Model
from ..problem import problem

NOTHING = 1e-6  # m: so little motion per typical size says nothing of a stiffness


@dataclass(frozen=True)
class Left:
    """An effect of the size that leaves a wanted mean error [m] beside refitted stiffness.

    size: of its first parameter; times: its typical size; raw: [m] mean deflection with it.
    """

    effect: Effect
    size: float
    times: float
    raw: float


def left_over(measured: Campaign, check: Campaign, effects: Sequence[Effect], wanted: float) -> list[Left]:
    """For each effect that leaves anything: linear, stiffness refitted on `measured`, error on `check`.

    measured, check: plans, all poses without load first and then all of them with it.
    """
    rows, probe = _moved(measured, effects), _moved(check, effects)
    springs, out = slice(len(effects), None), []
    A, B = rows.by[:, springs], probe.by[:, springs]
    firm = np.linalg.norm(A, axis=0) > NOTHING
    for i, effect in enumerate(effects):
        k = np.linalg.lstsq(A[:, firm], rows.by[:, i])[0]
        left = (probe.by[:, i] - B[:, firm] @ k).reshape(-1, 3)
        mean = float(np.linalg.norm(left, axis=1).mean())
        if mean * effect.params[0].typical < 1e-3 * NOTHING:
            continue
        size = wanted / mean
        raw = probe.nominal + size * probe.by[:, i].reshape(-1, 3)
        times = size / effect.params[0].typical
        out.append(Left(effect, size, times, float(np.linalg.norm(raw, axis=1).mean())))
    return sorted(out, key=lambda one: one.times)


@dataclass(frozen=True, eq=False)
class _Moved:
    """(M, 3) [m] what the load moves the first target by, and (3M, E + n) the change of that per unit."""

    nominal: Array
    by: Array


def _moved(plan: Campaign, effects: Sequence[Effect]) -> _Moved:
    job = problem(replace(plan, points=plan.points[:, :1], targets=plan.targets[:1]))
    model, half = Model(job), len(job.q) // 2
    line = model.linearise(model.start(np.eye(3)[None], np.zeros((1, 3)), job.stated_targets[None]))
    every = [*effects, *JointCompliance.sites(job)]
    one = [model.effect_jacobian(line, e, np.zeros(len(e.params)))[..., 0] for e in every]
    by = np.stack([(rows[half:] - rows[:half]).ravel() for rows in one], axis=1)
    points = line.prediction.base[:, 0]
    return _Moved(points[half:] - points[:half], by)
