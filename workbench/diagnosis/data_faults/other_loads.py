"""Poses that carried another payload than written, seen in how far the arm yields there."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from ...campaign import Campaign
from ...campaign.problem import Problem
from ...robot.kinematics import Array
from ..found import FaultFound

Predicts = Callable[[Problem], Array]  # the points (N, T, 3) [m] of a problem with other loads

WELL = 0.5  # of the distance from which a point is wild: what fits, and what no usual pose is off
NEARER = 0.3  # of how far it is off as written: what is off as the right payload has it


def carrying_what_fits(
    problem: Problem, predicted: Array, limit: Array, at: Predicts
) -> tuple[Problem, tuple[FaultFound, ...]]:
    """The problem with poses that are farther than `limit` (N, T) [m] from where they are predicted (N, T, 3)
    under the payload that brings them well within it, or most of the way, and which; where there is such a
    pose, others too that are off by less. at: predicts it under other payloads."""
    c = problem.campaign
    off = farthest(problem, np.linalg.norm(c.points - predicted, axis=2) / limit)
    if len(c.payload_names) < 2 or not (off > 1.0).any():
        return problem, ()
    other = farthest(problem, np.linalg.norm(_under_each_load(problem, at) - c.points, axis=3) / limit)
    nearest, least = other.argmin(axis=0), other.min(axis=0)
    wrong = (off > 1.0) & (least < np.maximum(WELL, NEARER * off))
    if not wrong.any():
        return problem, ()
    wrong |= (off > WELL) & (least < WELL * off)
    faults = tuple(_fault(c, n, c.payload_names[nearest[n]]) for n in np.flatnonzero(wrong).tolist())
    campaign = c.with_poses(payload=np.where(wrong, nearest, c.poses.payload))
    return replace(problem, campaign=campaign), faults


def farthest(problem: Problem, off: Array) -> Array:
    """(..., N) of distances (..., N, T) the largest of those points of each pose that were seen."""
    known = np.where(np.isfinite(off), off, np.inf)
    return np.asarray(np.where(problem.seen, known, 0.0).max(axis=-1))


def _fault(c: Campaign, n: int, fits: str) -> FaultFound:
    """That pose n carried another payload than written."""
    what = f"the points fit {called(fits)}, not {called(c.payload_names[c.poses.payload[n]])} as written"
    return FaultFound("wrong_payload", c.poses.ids[n], None, what, f"taken to carry {called(fits)}")


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


def called(payload: str) -> str:
    """A payload as people say it."""
    return f"payload {payload!r}" if payload else "no payload"
