"""What joints give under a weight at the flange, where the model has no masses: a sag by lever arms alone."""

from __future__ import annotations

import numpy as np

from ...effects.unnamed.loads import OwnWeights
from ...identification.fit import Fit
from ...robot.kinematics import Array


def sag(result: Fit) -> Array:
    """(N, D, s) whitened columns, one for each joint that weights turn, in usual sizes; s = 0 where the model
    has masses: what its joints give under these is a cause of its own."""
    problem = result.model.problem
    columns = [
        result.axial[:, :, problem.joint(one.where.joint)] * (one.size * one.x(problem))[:, None]
        for one in OwnWeights.sites(problem)
    ]
    return np.stack(columns, axis=2) if columns else np.zeros((*result.r.shape, 0))
