"""The effects of the catalogue that a campaign can show, at every place."""

from __future__ import annotations

from ..campaign.problem import Problem
from ..effects import catalogue
from ..effects.base import Effect
from ..effects.place import Where
from .result import NotTestable

AS_ROUNDED = "many poses have one written value of it, so coarse that its rounding may be all that is left"


def testable(problem: Problem) -> tuple[list[Effect], list[NotTestable]]:
    """Candidates of the catalogue at every place, and the causes that the data cannot show."""
    candidates: list[Effect] = []
    missing: list[NotTestable] = []
    for cause, kind in catalogue().items():
        why = kind.needs(problem)
        if why is not None:
            missing.append(NotTestable(cause, why))
            continue
        sites = kind.sites(problem)
        if kind.as_rounded and problem.rounded:
            missing += [NotTestable(cause, AS_ROUNDED, Where(joint=joint)) for joint in problem.rounded]
            sites = [site for site in sites if site.where.joint not in problem.rounded]
        candidates += sites
    return candidates, missing
