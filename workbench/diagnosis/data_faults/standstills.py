"""Rows on end at which the arm stood where it stood before: shots of one standstill, and no further poses.

What the arm is off by there is the same in all of them. As poses of their own they would say it several times
over: noise that no robot has, and a function of the joints for every pose.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...campaign.poses import Array, Column
from ...campaign.problem import Problem
from ...identification.repeats import repeat_groups
from ..found import FaultFound

LONGEST = 120.0  # s between the first and the last: from there on arm, stand or hall may have moved
WARMER = 0.5  # K, of the same
ON_END = 0.5  # of all repeats: where fewer are, the arm goes away and comes back, now and then at once
AVERAGED = "time", "temperature", "torque", "readback"
WILD = 15.0  # times the usual distance from the middle of a standstill's shots: another thing was hit


def taken_together(problem: Problem) -> tuple[Problem, tuple[FaultFound, ...], tuple[str, ...]]:
    """The problem with rows on end of the same joints, load, set-up and sides of approach as shots of one
    pose, which has the first one's name; wild shots among them as faults, and a remark."""
    campaign, group = problem.campaign, repeat_groups(problem)
    moved, repeats = _moved(campaign, group), len(group) - len(np.unique(group))
    first, number = np.flatnonzero(moved), np.cumsum(moved) - 1
    if len(moved) - len(first) < max(1.0, ON_END * repeats):
        return problem, (), ()
    points, faults = _without_wild(campaign, number)
    count = np.asarray(np.isfinite(points).all(axis=2))
    shots = np.where(count, np.maximum(campaign.shots, 1), 0)
    weight = shots[..., None].astype(float)
    total = _summed(weight, number)
    share = weight / np.where(total > 0, total, np.nan)[number]
    mean = _summed(share * np.nan_to_num(points), number)
    off = np.where(count[..., None], points - mean[number], 0.0)
    free = 3 * int((_summed(count, number) - 1).clip(0).sum())
    square, dof = campaign.shot_scatter
    sigma = campaign.sigma
    if sigma is not None:
        sigma = np.sqrt(_summed((share * np.nan_to_num(sigma)) ** 2, number))
    means = {name: _mean(getattr(campaign.poses, name), number) for name in AVERAGED}
    together = replace(
        campaign.some(first).with_poses(**means),
        points=mean,
        shots=_summed(shots, number).astype(np.int64),
        sigma=sigma,
        shot_scatter=(square + float((weight * off**2).sum()), dof + free),
        of_rows=True,
    )
    more = len(campaign.poses) - len(first)
    rows = "1 row has the joints" if more == 1 else f"{more} rows have the joints"
    told = (
        f"{rows} of the row before: taken for further shots of one standstill. Rows for which the arm went "
        "away and came back say more in another order."
    )
    return replace(problem, campaign=together), faults, (told,)


def _moved(campaign: Campaign, group: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(N,) the row is no repeat of the row before, by the groups of repeats (N,), or time has passed."""
    poses, moved = campaign.poses, np.append(True, np.diff(group) != 0)
    for passing, most in ((poses.time, LONGEST), (poses.temperature, WARMER)):
        if passing is not None:
            number, passing = np.cumsum(moved) - 1, np.nan_to_num(passing)
            least, largest = (np.full(number[-1] + 1, end) for end in (np.inf, -np.inf))
            np.minimum.at(least, number, passing)
            np.maximum.at(largest, number, passing)
            moved |= (largest - least > most)[number]
    return np.asarray(moved)


def _without_wild(campaign: Campaign, number: NDArray[np.int64]) -> tuple[Array, tuple[FaultFound, ...]]:
    """The points (N, T, 3) without shots far off the middle one of their standstill, and these as faults."""
    points = campaign.points.copy()
    off = np.linalg.norm(points - _middle(points, number), axis=2)
    several = np.isfinite(off) & (_summed(np.isfinite(off), number)[number] > 2)
    usual = float(np.median(off[several])) if several.any() else np.inf
    wild = several & (off > WILD * usual + 1e-6)
    if campaign.six_dof:  # it is one measurement
        wild |= wild.any(axis=1)[:, None]
    faults = []
    for i, t in np.argwhere(wild):
        name, target = campaign.poses.ids[i], campaign.targets[t].name
        what = f"{1e3 * off[i, t]:.3f} mm off the other shots of this standstill"
        faults.append(FaultFound("outlier", name, target, what, "left out"))
        points[i, t] = np.nan
    return points, tuple(faults)


def _middle(points: Array, number: NDArray[np.int64]) -> Array:
    """(N, T, 3) the median of each row's standstill."""
    out = np.empty_like(points)
    ends = np.flatnonzero(np.diff(number)) + 1
    for rows in np.split(np.arange(len(number)), ends):
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            out[rows] = np.nanmedian(points[rows], axis=0)
    return out


def _summed(values: NDArray[Any], number: NDArray[np.int64]) -> Array:
    """Sums over the rows (N, ...) of each standstill."""
    out = np.zeros((number[-1] + 1, *values.shape[1:]))
    np.add.at(out, number, values)
    return out


def _mean(values: Column, number: NDArray[np.int64]) -> Column:
    """The mean of a column's numbers at each standstill, NaN where there are none."""
    if not isinstance(values, np.ndarray):
        return values
    there = np.isfinite(values)
    count = _summed(there, number)
    return np.asarray(_summed(np.where(there, values, 0.0), number) / np.where(count > 0, count, np.nan))
