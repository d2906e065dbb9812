"""What correction leaves where the robot was measured, and all over its range.

Poses that are held out are of the design that was measured: of one that hardly turns its tool they say
nothing of the rest of the workspace, where the model may be off by a hundred times as much.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..campaign.planned import random_poses
from ..files.faults import InputError
from ..identification.model_file import as_robot
from ..identification.prediction import predict
from ..robot.equilibrium import NoRest
from .run import Outcome

POSES = 100  # at most, of either


def with_bounds(outcome: Outcome) -> Outcome:
    """The outcome with what its model leaves at half of the measured poses, and of poses drawn over the
    joints' whole range, mm, 95 %; as it is where that is not known, or the arm does not stand there."""
    if outcome.diagnosis.bounds_mm is not None:
        return outcome
    robot = as_robot(outcome.fit)
    if robot.uncertainty is None:
        return outcome
    measured = outcome.problem.campaign
    some = np.unique(np.linspace(0, len(measured.poses) - 1, POSES).astype(int))
    try:
        q = random_poses(robot, POSES, np.random.default_rng(0), share=1.0)
        errors = [predict(robot, measured.some(some), own_frame=False), predict(robot, q)]
    except (NoRest, InputError):
        return outcome
    near, far = (1e3 * float(np.median(one.worst)) for one in errors)
    return replace(outcome, diagnosis=replace(outcome.diagnosis, bounds_mm=(near, far)))
