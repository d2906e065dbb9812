"""The effects of the catalogue that a campaign can show, at every place."""

from __future__ import annotations

from collections.abc import Sequence

from ..campaign.problem import Problem
from ..effects import catalogue
from ..effects.base import Effect
from ..effects.place import Where
from ..effects.unnamed import unnamed
from .found import NotTestable

NO_WEIGHTS = "no masses in the URDF, and one load in all poses: state the masses, or measure with two loads"
AS_ROUNDED = "many poses have one written value of it, so coarse that its rounding may be all that is left"


def untold(kind: type[Effect], problem: Problem) -> str | None:
    """Why a campaign cannot tell of a cause; None where it can. Where the model has no masses one load that
    is always there looks like these: neither it nor what yields is told."""
    if (why := kind.needs(problem)) or problem.weights_known:
        return why
    return NO_WEIGHTS if kind.acts == "yielding" or not kind.sites(problem) else None


def testable(problem: Problem) -> tuple[list[Effect], list[NotTestable]]:
    """Candidates of the catalogue at every place, and the causes that the data cannot show."""
    candidates: list[Effect] = []
    missing: list[NotTestable] = []
    for cause, kind in catalogue().items():
        why = untold(kind, problem)
        if why is not None:
            missing.append(NotTestable(cause, why))
            continue
        sites = kind.sites(problem)
        if kind.as_rounded and problem.rounded:
            missing += [NotTestable(cause, AS_ROUNDED, Where(joint=joint)) for joint in problem.rounded]
            sites = [site for site in sites if site.where.joint not in problem.rounded]
        candidates += sites
    return candidates, missing


def ways_to_wander(problem: Problem, candidates: Sequence[Effect]) -> list[Effect]:
    """Ways in which something wanders in time, with or without a name: those with most numbers, which hold
    the others nearly."""
    every = [e for e in (*candidates, *unnamed(problem)) if e.uses == {"time"} and not e.lasting]
    most = max((len(e.params) for e in every), default=0)
    return [e for e in every if len(e.params) == most]
