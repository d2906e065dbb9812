"""The effects of the catalogue that a campaign can show, at every place."""

from __future__ import annotations

from ..campaign.problem import Problem
from ..effects import catalogue
from ..effects.base import Effect
from .result import NotTestable


def testable(problem: Problem) -> tuple[list[Effect], list[NotTestable]]:
    """Candidates of the catalogue at every place, and the causes that the data cannot show."""
    candidates: list[Effect] = []
    missing: list[NotTestable] = []
    for cause, kind in catalogue().items():
        why = kind.needs(problem)
        if why is not None:
            missing.append(NotTestable(cause, why))
            continue
        candidates += kind.sites(problem)
    return candidates, missing
