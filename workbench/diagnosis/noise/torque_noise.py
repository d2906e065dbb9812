"""Noise of the drives' torques, with the load that is most likely wrong beside the model's own."""

from __future__ import annotations

import numpy as np

from ...campaign import drive_torque, torque_columns
from ...effects import catalogue
from ...effects.base import Effect
from ...identification.fit import Fit
from ...robot.kinematics import Array
from ..priors import PRIORS

MOST = 3.0  # standard deviations of the widest prior that passes for a cause


def torque_noise(fit: Fit) -> Array:
    """(n,) one sigma of each joint's torque [N·m, N] as `torque_columns.noise` takes it, at a fit of
    poses with torques: what is left of them with the one cause of the catalogue that explains most in a size
    that passes for a cause, so that a wrong load does not hide itself."""
    problem = fit.model.problem

    def left(moved: Array | None) -> float:
        rms = drive_torque.scatter(problem, moved, MOST * PRIORS.largest)
        return float(np.log(rms[np.isfinite(rms)]).sum())

    best = min([None, *_moved(fit)], key=left)
    return torque_columns.noise(problem, best, MOST * PRIORS.largest)


def _moved(fit: Fit) -> list[Array]:
    """(N, n, p) what each load that may be wrong, at its place, makes of the torques."""
    problem = fit.model.problem
    places: dict[object, list[Effect]] = {}
    for kind in catalogue().values():
        if kind.acts == "load" and kind.needs(problem) is None:
            for effect in kind.sites(problem):
                places.setdefault(effect.key, []).append(effect)
    return [np.concatenate([_column(fit, e) for e in effects], axis=2) for effects in places.values()]


def _column(fit: Fit, effect: Effect) -> Array:
    typical = np.array([p.typical for p in effect.params])
    slope = fit.model.effect_jacobian(fit.line, effect, np.zeros(len(typical)))
    return np.asarray(slope[:, -fit.model.problem.drives :] * typical)
