"""Offline path modification: commands that put the extended robot's tool where the path wants it."""

from .command import Compensation, compensate
from .conditions import Conditions, conditions_of, stated_conditions
from .file import Export, Written, compensate_file
from .in_place import Corrected, compensate_program, is_program
from .ripple import LeftOut
from .trajectory import nominal_joints
from .trouble import Trouble

__all__ = [
    "Compensation",
    "Conditions",
    "Corrected",
    "Export",
    "LeftOut",
    "Trouble",
    "Written",
    "compensate",
    "compensate_file",
    "compensate_program",
    "conditions_of",
    "is_program",
    "nominal_joints",
    "stated_conditions",
]
