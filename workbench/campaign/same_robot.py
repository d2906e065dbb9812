"""Whether a campaign is of a robot: the same joints at the same places, whatever was found of it since."""

from __future__ import annotations

import numpy as np

from ..files.faults import Fault, InputError
from ..robot.description import Robot
from ..robot.rigid_plant import arrays
from .data import Campaign

SAME = 1e-4  # m; and of the axes' directions: a URDF with few digits is the same robot


def check_same_robot(robot: Robot, campaign: Campaign) -> None:
    """Raises InputError for the campaign of another robot, whose poses and loads say nothing here: many
    robots call their joints alike."""
    own, other = (arrays(one) for one in (robot, campaign.robot))
    same = own.names == other.names and all(
        np.allclose(a, b, atol=SAME) for a, b in ((own.p, other.p), (own.R, other.R))
    )
    if not same:
        what = f"is of {campaign.robot.name}, which is not the robot of {robot.path or robot.name}"
        raise InputError(Fault(str(campaign.path), what, "name a campaign of this robot"))
