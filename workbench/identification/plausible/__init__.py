"""Whether joints, points and robot belong together, before anything is fitted to explain them."""

from .check import Plausible, believed, judge
from .few_poses import enough_beside_others, enough_poses, enough_together, too_few_alone
from .machine import check_rest, plausible_geometry
from .same_factor import common_factor

__all__ = [
    "Plausible",
    "believed",
    "check_rest",
    "common_factor",
    "enough_beside_others",
    "enough_poses",
    "enough_together",
    "judge",
    "plausible_geometry",
    "too_few_alone",
]
