"""Variable parameters: cells of the workspace with kinematics and stiffness of their own (source 001)."""

from .count import Trade, trade
from .file import load_cells, write_cells
from .grid import Cells, cells
from .left import Left, left_over
from .load import external, identified, part, predicted, seated
from .model import CellModel, Commands, fit_cells

__all__ = [
    "CellModel",
    "Cells",
    "Commands",
    "Left",
    "Trade",
    "cells",
    "external",
    "fit_cells",
    "identified",
    "left_over",
    "load_cells",
    "part",
    "predicted",
    "seated",
    "trade",
    "write_cells",
]
