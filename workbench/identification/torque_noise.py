"""Noise of the drives' torques, with every load that may be wrong beside the model's own."""

from __future__ import annotations

import numpy as np

from ..campaign import drive_torque
from ..effects import catalogue
from ..robot.kinematics import Array
from .fit import Fit


def torque_noise(fit: Fit) -> Array:
    """(n,) one sigma of each joint's torque [N·m, N] as `drive_torque.noise` takes it, at a fit of poses
    with torques: what no load of the catalogue can make, whichever of them is there."""
    problem = fit.model.problem
    kinds = [kind for kind in catalogue().values() if kind.acts == "load" and kind.needs(problem) is None]
    moved = [np.zeros((len(problem.q), problem.drives, 0))]
    for effect in (effect for kind in kinds for effect in kind.sites(problem)):
        slope = fit.model.effect_jacobian(fit.line, effect, np.zeros(len(effect.params)))
        moved.append(slope[:, -problem.drives :] * [p.typical for p in effect.params])
    return drive_torque.noise(problem, np.concatenate(moved, axis=2))
