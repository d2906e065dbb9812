"""Prediction of the error at the tool, with bounds that held on held-out poses."""

from .at_poses import ToolErrors, posed, predict, required_uncertainty
from .of_fit import uncertainty

__all__ = ["ToolErrors", "posed", "predict", "required_uncertainty", "uncertainty"]
