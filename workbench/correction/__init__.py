"""Offline path modification: commands that put the extended robot's tool where the path wants it."""

from .command import Compensation, compensate
from .conditions import Conditions, conditions_of, stated_conditions
from .file import Written, compensate_file
from .ripple import LeftOut
from .trajectory import nominal_joints
from .trouble import Trouble

__all__ = [
    "Compensation",
    "Conditions",
    "LeftOut",
    "Trouble",
    "Written",
    "compensate",
    "compensate_file",
    "conditions_of",
    "nominal_joints",
    "stated_conditions",
]
