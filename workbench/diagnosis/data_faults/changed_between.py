"""What changed between campaigns and is nothing of the arm: its zeros, where it was mastered anew or hit
something; what it carries, where another tool or payload was mounted than is stated; the scale of lengths.

Fitted as one robot, two zeros of a joint are an error of a thousandth of the arm's reach in every pose of
both, in which any cause drowns. That is no cause: what the controller counts from is written down otherwise.
Nor is a load that was changed unsaid; not told as that, it looks like a joint's zero that moved.
"""

from __future__ import annotations

import numpy as np

from ...campaign.problem import Problem
from ..found import FaultFound
from ..priors import PRIORS
from ..search.competition import Selection


def changed_between(selection: Selection) -> tuple[Problem, tuple[FaultFound, ...]]:
    """The problem with joints counted and lengths scaled in all campaigns as in the last, and with what the
    arm carries in each, where a search is as sure of that as a name asks for; and what was found. Beside
    causes: what a cause explains as well is none."""
    final = selection.fit
    problem, faults = final.model.problem, list[FaultFound]()
    sure = {
        selection.components[m.component].effect
        for m, share in zip(selection.members, selection.shares, strict=True)
        if share.get(m.component, 0.0) >= PRIORS.named
    }
    known = {(one.key, one.variant) for one in sure if one is not None}
    for i, effect in enumerate(final.model.effects):
        if (effect.key, effect.variant) not in known:
            continue
        values, covariance = final.effect_values(i)
        was = effect.as_it_was(problem, values, np.sqrt(np.diag(covariance)))
        if was is None:
            continue
        poses = was.campaign.poses
        for setup, what in was.said:
            first = int(np.argmax(poses.setup == setup))
            faults.append(FaultFound(was.kind, poses.ids[first], None, what, was.done))
        problem = Problem(problem.robot, problem.arm, was.campaign, problem.compensator)
    return problem, tuple(faults)
