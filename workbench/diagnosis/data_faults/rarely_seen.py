"""Targets and set-ups that were measured so seldom that they say no more than their own place: left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...campaign.problem import Problem
from ..found import FaultFound
from .wild_points import Mended

LEAST_POSITIONS = 3  # of the joints, of which one may be held out and the place is still known


def without_rarely_seen(problem: Problem) -> Mended:
    """Without the targets on the arm whose place is fitted, or whose whole set-up is, on points at fewer than
    `LEAST_POSITIONS` joint positions: they tell the robot nothing, and where they are held out nobody knows
    their place. Mostly a name that was mistyped."""
    c, positions = problem.campaign, problem.positions
    points, faults = c.points.copy(), []
    on_arm = np.array(problem.on) > 0
    for k, setup in enumerate(c.setup_names):
        here = c.poses.setup == k
        count = np.array([len(np.unique(positions[here & seen])) for seen in problem.seen.T]) * on_arm
        whole = len(np.unique(positions[here & problem.seen[:, on_arm].any(axis=1)]))
        if whole < LEAST_POSITIONS:
            points[here] = np.nan
            first = c.poses.ids[int(np.argmax(here))]
            said = f"set-up {setup!r} was measured at {_positions(whole)}, which give no more than its frame"
            faults.append(FaultFound("rare_setup", first, None, said, "all its points left out"))
            continue
        for i in np.flatnonzero((count > 0) & (count < LEAST_POSITIONS)):
            if c.targets[i].fixed:
                continue
            first = c.poses.ids[np.flatnonzero(here & problem.seen[:, i])[0]]
            said = f"measured at {_positions(count[i])}, which give no more than its own place"
            points[here, i] = np.nan
            faults.append(
                FaultFound("rare_target", first, c.targets[i].name, said, "all its points left out")
            )
    if not faults or not np.isfinite(points).any():
        return Mended(problem, ())
    return Mended(replace(problem, campaign=replace(c, points=points)), tuple(faults))


def _positions(count: int) -> str:
    return f"{count} position{'s' if count != 1 else ''} of the joints"
