"""How far what tilts under moment is off the even law."""

from __future__ import annotations

from collections.abc import Sequence

from ..campaign.problem import Problem
from .base import Effect
from .kinds import LinearYield
from .unnamed.loads import UnevenTilt

SHARE = 0.3  # of the tilt


def uneven(tilt: LinearYield, problem: Problem) -> Sequence[tuple[float, Effect]]:
    """The uneven part of a tilt, with its share of it."""
    out = []
    for one in UnevenTilt.sites(problem):
        if one.slot != tilt.slot(problem.arm):
            continue
        typical = tilt.params[0].typical * one.largest / one.size if tilt.stated else 1.0
        out.append((SHARE * typical, one))
    return out
