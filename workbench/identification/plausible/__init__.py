"""Whether joints, points and robot belong together, before anything is fitted to explain them."""

from .check import Plausible, check_plausible, judge
from .few_poses import enough_poses
from .machine import check_corrections, check_rest

__all__ = ["Plausible", "check_corrections", "check_plausible", "check_rest", "enough_poses", "judge"]
