"""What changed between campaigns and is nothing of the arm: its zeros, where it was mastered anew or hit
something, or what it carries, where another tool or payload was mounted than is stated.

Fitted as one robot, two zeros of a joint are an error of a thousandth of the arm's reach in every pose of
both, in which any cause drowns. That is no cause: what the controller counts from is written down otherwise.
Nor is a load that was changed unsaid; not told as that, it looks like a joint's zero that moved.
"""

from __future__ import annotations

import numpy as np

from ...campaign.problem import Problem
from ...effects.given import DataFault
from ..priors import PRIORS
from ..result import FaultFound
from ..search.competition import SURELY, Selection

DONE = "counted there as in the last campaign, whose zeros the model has"
CARRIED = "taken to carry that there; state it in that campaign"


def changed_between(selection: Selection) -> tuple[Problem, tuple[FaultFound, ...]]:
    """The problem with joints counted in all campaigns as in the last, and with what the arm carries in each,
    where a search is as sure of that as a name asks for; and what was found. Beside causes: what a cause
    explains as well is none."""
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
        std = np.sqrt(np.diag(covariance))
        said = effect.said_by_setup(problem, values, std)
        c = effect.as_carried(problem, values)
        if c is not None:
            faults += [_fault("changed_load", problem, *one, CARRIED) for one in said]
        else:
            stays = np.abs(values) <= SURELY * std  # in campaigns of which others alone are off
            q = effect.as_commanded(problem, np.where(stays, 0.0, values))
            if q is None:
                continue
            moved = [one for one, same in zip(said, stays, strict=True) if not same]
            faults += [_fault("moved_zero", problem, *one, DONE) for one in moved]
            c = problem.campaign.with_poses(q=q)
        problem = Problem(problem.robot, problem.arm, c, problem.compensator)
    return problem, tuple(faults)


def _fault(kind: DataFault, problem: Problem, setup: int, what: str, done: str) -> FaultFound:
    """What is otherwise in a set-up, told at its first pose."""
    first = int(np.argmax(problem.campaign.poses.setup == setup))
    return FaultFound(kind, problem.campaign.poses.ids[first], None, what, done)
