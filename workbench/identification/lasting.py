"""A fit without what nobody knows and another campaign would not have."""

from __future__ import annotations

from ..effects.base import UNKNOWN
from .fit import Fit, refit


def lasting(fit: Fit) -> Fit:
    """The fit without functions that have no name and do not stay with the robot (of bearing, order, time).

    The rest is fitted again: part of what they took may be the robot's, and a model predicts without them.
    """
    kept = [e for e in fit.model.effects if e.cause != UNKNOWN or e.lasting]
    return fit if len(kept) == len(fit.model.effects) else refit(fit, kept)
