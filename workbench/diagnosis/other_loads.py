"""Payloads that are written at other poses than those that carried them: seen in how far the arm yields."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from ..campaign import Campaign
from ..campaign.problem import Problem
from ..files.faults import Fault, InputError
from ..identification.fit import Fit
from ..robot.kinematics import Array
from .result import FaultFound

Index = NDArray[np.int64]
Predicts = Callable[[Problem], Array]  # the points (N, T, 3) [m] of a problem with other loads

MOST = 4  # payloads that are tried in each other's places: 23 ways
WELL = 0.5  # of the distance from which a point is wild: what fits, and what no usual pose is off
NEARER = 0.3  # of how far it is off as written: what is off as the right payload has it
CLEARER = 0.5  # of the squares at most is left in the right order: an arm never yields against its load


def carrying_what_fits(
    problem: Problem, predicted: Array, limit: Array, at: Predicts
) -> tuple[Problem, tuple[FaultFound, ...]]:
    """The problem with poses that are farther than `limit` (N, T) [m] from where they are predicted (N, T, 3)
    under the payload that brings them well within it, or most of the way, and which; where there is such a
    pose, others too that are off by less. at: predicts it under other payloads."""
    c = problem.campaign
    off = _farthest(problem, np.linalg.norm(c.points - predicted, axis=2) / limit)
    if len(c.payload_names) < 2 or not (off > 1.0).any():
        return problem, ()
    other = _farthest(problem, np.linalg.norm(_under_each_load(problem, at) - c.points, axis=3) / limit)
    nearest, least = other.argmin(axis=0), other.min(axis=0)
    wrong = (off > 1.0) & (least < np.maximum(WELL, NEARER * off))
    if not wrong.any():
        return problem, ()
    wrong |= (off > WELL) & (least < WELL * off)
    faults = tuple(_fault(c, n, c.payload_names[nearest[n]]) for n in np.flatnonzero(wrong).tolist())
    campaign = c.with_poses(payload=np.where(wrong, nearest, c.poses.payload))
    return replace(problem, campaign=campaign), faults


def _farthest(problem: Problem, off: Array) -> Array:
    """(..., N) of distances (..., N, T) the largest of those points of each pose that were seen."""
    known = np.where(np.isfinite(off), off, np.inf)
    return np.asarray(np.where(problem.seen, known, 0.0).max(axis=-1))


def _fault(c: Campaign, n: int, fits: str) -> FaultFound:
    """That pose n carried another payload than written."""
    what = f"the points fit {_called(fits)}, not {_called(c.payload_names[c.poses.payload[n]])} as written"
    return FaultFound("wrong_payload", c.poses.ids[n], None, what, f"taken to carry {_called(fits)}")


def _under_each_load(problem: Problem, at: Predicts) -> Array:
    """(K, N, T, 3) [m] where the points are predicted if every pose carried payload k of the campaign's K;
    NaN of payloads under which the arm finds no rest."""
    c = problem.campaign
    out = np.full((len(c.payload_names), *c.points.shape), np.nan)
    for k in range(len(out)):
        every = c.with_poses(payload=np.full(len(c.poses), k))
        with suppress(ArithmeticError):
            out[k] = at(replace(problem, campaign=every))
    return out


def refuse_exchanged(result: Fit) -> None:
    """Raises `InputError` where the points fit the payloads in each other's places, at all poses that carry
    them: then the arm yields least under the heaviest. result: a robust fit of the geometry."""
    problem = result.model.problem
    used = np.unique(problem.campaign.poses.payload)
    if not 2 <= len(used) <= MOST:
        return
    under_each = _under_each_load(problem, result.at)
    left = {order: _left(result, under_each, used, order) for order in permutations(used.tolist())}
    own, best = tuple(used.tolist()), min(left, key=left.__getitem__)
    if left[best] > CLEARER * left[own]:
        return
    names = problem.campaign.payload_names
    said = ", ".join(
        f"{_called(names[b])} where {_called(names[a])} is written"
        for a, b in zip(own, best, strict=True)
        if a != b
    )
    share = np.sqrt(left[best] / left[own])
    what = f"payload: the arm yields as under {said}, which leaves {share:.0%} of the error"
    mend = "exchange the payloads' masses, or their names at the poses"
    raise InputError(Fault(str(problem.campaign.path), what, mend))


def _called(payload: str) -> str:
    """A payload as people say it."""
    return f"payload {payload!r}" if payload else "no payload"


def _left(result: Fit, under_each: Array, used: Index, order: Sequence[int]) -> float:
    """Squares that the fit leaves, to first order, where the poses of payload used[i] carried order[i].
    under_each: (K, N, T, 3) [m]."""
    campaign, normal = result.model.problem.campaign, result.normal
    carried = np.array(order)[np.searchsorted(used, campaign.poses.payload)]
    points = under_each[carried, np.arange(len(carried))]
    moved = np.where(result.model.problem.seen[..., None], result.line.prediction.points - points, 0.0)
    by_points = result.whitener[:, :, : moved[0].size]
    r = (result.r + np.matmul(by_points, moved.reshape(len(moved), -1, 1))[..., 0]).ravel()
    if not np.isfinite(r).all():
        return np.inf
    again = replace(normal, r=r, g=(normal.J.T @ r) * normal.prior - normal.offset)
    return float(r @ r + normal.offset @ normal.offset - again.gain(again.step(0.0).change))
