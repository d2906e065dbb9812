"""Prediction of the error at the tool, with bounds that held on held-out poses."""

from .at_poses import ToolErrors, ToolTurns, posed, predict, required_uncertainty
from .of_fit import uncertainty

__all__ = ["ToolErrors", "ToolTurns", "posed", "predict", "required_uncertainty", "uncertainty"]
