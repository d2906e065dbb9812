"""What tool, payload and external wrench put on the flange, and whether it was measured so."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..robot.kinematics import Array
from .data import Campaign
from .problem import Problem

MARGIN = 0.1  # of the largest measured force or moment
LIGHT_FORCE, LIGHT_MOMENT = 1.0, 0.1  # N, N·m: no less counts,
LEVER = 3e-3  # m: nor a force that pulls so near to where it did, as under a hand a little askew


def flange_load(problem: Problem) -> tuple[float, float, float]:
    """Least and largest force [N] and largest moment [N·m] on the flange in a campaign."""
    force, moment = _sizes(problem)
    return float(force.min()), float(force.max()), float(moment.max())


def external_forces(campaign: Campaign) -> str:
    """In how many poses something pulls at the flange from outside, and how much; empty where in none."""
    wrench = campaign.poses.wrench
    force, moment = (np.linalg.norm(part, axis=1) for part in np.split(wrench, 2, axis=1))
    count, of = np.count_nonzero(wrench.any(axis=1)), len(wrench)
    if not count:
        return ""
    most = f"up to {force.max():.4g} N and {moment.max():.4g} N·m at the flange's origin"
    return f"in {count} of {of} poses, {most}"


def beyond_load(problem: Problem, measured: Sequence[float]) -> NDArray[np.bool_]:
    """(N,) which poses load the flange otherwise than in the campaign of which `measured` is the
    `flange_load`; none where it is not known (empty)."""
    force, moment = _sizes(problem)
    if not measured:
        return np.zeros(len(force), dtype=bool)
    least, most, turning = measured
    margin = max(LIGHT_FORCE, MARGIN * most)
    off = (force < least - margin) | (force > most + margin)
    return np.asarray(off | (moment > turning + max(LIGHT_MOMENT, LEVER * most, MARGIN * turning)))


def _sizes(problem: Problem) -> tuple[Array, Array]:
    """(N,) force [N] and moment [N·m] about the flange's origin."""
    load = problem.nominal_load
    return np.linalg.norm(load.force[:, -1], axis=1), np.linalg.norm(load.moment[:, -1], axis=1)
