"""What warms up, or creeps, in time: fast at first, then ever slower."""

from __future__ import annotations

import numpy as np

from ..campaign.problem import Problem
from ..robot.kinematics import Array

SHARES = (0.15, 0.4, 1.0)  # time constants that are tried, as shares of the campaign's duration
SOONEST = 0.05  # the same of what could be taken for a step
HOUR = 3600.0  # s: duration where no time was recorded


def start_and_span(problem: Problem) -> tuple[float, float]:
    """First instant [s] of a campaign, and its duration [s]."""
    time = np.zeros(1) if problem.time is None else problem.time
    return float(time.min()), float(np.ptp(time)) or HOUR


def share_gone(since: Array, constant: float) -> Array:
    """(N,) share of the whole way after times `since` [s], by a time constant [s]; none before the start."""
    return np.asarray(1 - np.exp(-np.maximum(since, 0.0) / constant))


def since_start(problem: Problem, start: float) -> Array:
    """(N,) [s] since an instant `start`; nothing where no time was recorded."""
    return np.zeros(len(problem.q)) if problem.time is None else problem.time - start


def gone(since: Array, constant: float) -> Array:
    """(N,) [s] how long it would have gone at its first speed, after `since` (N,) [s]; constant 0: evenly."""
    return constant * share_gone(since, constant) if constant else since
