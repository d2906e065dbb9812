"""Cells of the workspace with kinematics and stiffness of their own (Jiao et al. 2020)."""

from .cell_model import CellModel, Commands, fit_cells
from .file import load_cells, write_cells
from .grid import Cells, cells

__all__ = ["CellModel", "Cells", "Commands", "cells", "fit_cells", "load_cells", "write_cells"]
