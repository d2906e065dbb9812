"""A robot as its model has it, set up: frames and targets alone are fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .fit import Fit, fit
from .model import Model, State
from .noise import Covariance


def fit_set_up(model: Model, start: State, noise: Covariance) -> Fit:
    """Frames and targets of a robot of which nothing else is fitted.

    What the robot errs by counts as noise, and as one that all joint positions have in common: by the
    instrument's alone, or by what many positions leave on average, a target that they hardly tell from the
    frame (a tool that never turns, but sags) would go far away for the micrometres that it takes in there.

    Turns of a 6-D measurement count as much as they move its points: what such a robot errs by is neither the
    instrument's noise of turns nor what its joints scatter.
    """
    if model.problem.campaign.six_dof:
        none = np.zeros_like(noise.joint)
        noise = replace(noise, joint=none, body=(0.0, 0.0), turn_ratio=1.0, about=-1)
    found = fit(model, start, noise, geometry=False)
    free = max(found.point_rows - found.rank, 1)
    times = float(np.sqrt(found.chi2 / free))
    if times <= 1:
        return found
    positions = int(model.problem.positions.max()) + 1
    return fit(model, start, noise.times(times * np.sqrt(positions)), geometry=False)
