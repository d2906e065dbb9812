"""Zeros that moved between campaigns: the robot was mastered anew, or hit something, and is the same beside.

Fitted as one robot, two zeros of a joint are an error of a thousandth of the arm's reach in every pose of
both, in which any cause drowns. That is no cause: what the controller counts from is written down otherwise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...campaign.problem import Problem
from ..priors import PRIORS
from ..result import FaultFound
from ..search.competition import SURELY, Selection

DONE = "counted there as in the last campaign, whose zeros the model has"


def moved_zeros(selection: Selection) -> tuple[Problem, tuple[FaultFound, ...]]:
    """The problem with joints counted in all campaigns as in the last, where a search is as sure of that as a
    name asks for; and what was found. Beside causes: what a cause explains as well is none."""
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
        stays = np.abs(values) <= SURELY * std  # in campaigns of which others alone are off
        q = effect.as_commanded(problem, np.where(stays, 0.0, values))
        if q is None:
            continue
        c = problem.campaign
        for (setup, what), same in zip(effect.said_by_setup(problem, values, std), stays, strict=True):
            if same:
                continue
            first = int(np.argmax(c.poses.setup == setup))
            faults.append(FaultFound("moved_zero", c.poses.ids[first], None, what, DONE))
        campaign = replace(c, poses=replace(c.poses, q=q))
        problem = Problem(problem.robot, problem.arm, campaign, problem.compensator)
    return problem, tuple(faults)
