"""Loads that are stated otherwise than they were: payloads exchanged, wrenches (`mistaken_wrenches`),
gravity of an arm that stands on no floor. Seen in how far the arm yields to them, by the
model's stiffnesses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import permutations

import numpy as np

from ...campaign.problem import Problem
from ...files.faults import Fault, InputError
from ...identification.fit import Fit
from .mistaken_wrenches import (
    AGAINST,
    ALONG,
    Mistake,
    acting_elsewhere,
    begun,
    of_another_size,
    squares_left,
    stated_otherwise,
)
from .other_loads import called

MOST = 4  # payloads that are tried in each other's places: 23 ways
COSINE = 0.5  # of the angle between directions of gravity that are two


def mistaken_loads(result: Fit) -> list[str]:
    """A remark on wrenches in another unit, where the points fit these by the model's stiffnesses alone, and
    on forces that act elsewhere, where that brings less. Raises `InputError` where they fit payloads in each
    other's places, gravity that acts another way, or wrenches that act so, whatever the stiffnesses.
    result: a robust fit of the geometry."""
    problem = result.model.problem
    possible = list(_mistakes(problem))
    own = _left(result, problem) if possible else 0.0
    if own > 0.0:
        shares = [_left(result, one.problem) / own for one in possible]
        left, best = min(zip(shares, possible, strict=True), key=lambda pair: pair[0])
        if left <= best.enough:
            raise _refused(problem, best, left)
    return _of_wrenches(result) if problem.campaign.poses.wrench.any() else []


def _of_wrenches(result: Fit) -> list[str]:
    """The same of wrenches."""
    problem = result.model.problem
    first = begun(result)
    eased = squares_left(first, problem)
    sizes = list(of_another_size(problem))
    if 0.0 < eased < np.inf:
        ways = [*stated_otherwise(problem, first.state.R), *(one for _, one in sizes)]
        shares = [squares_left(first, one.problem) / eased for one in ways]
        left, best = min(zip(shares, ways, strict=True), key=lambda pair: pair[0])
        if left <= best.enough:
            raise _refused(problem, best, left)
        if (there := acting_elsewhere(first)) is not None:
            left = squares_left(first, there.problem) / eased
            if left <= there.enough:
                raise _refused(problem, there, left)
            if left <= AGAINST:
                return [_remark(there.what, left, there.mend)]
    own = _left(result, problem)
    if own == 0.0:
        return []
    shares = [_left(result, one.problem) / own for _, one in sizes]
    left, (mistaken, unit) = min(zip(shares, sizes, strict=True), key=lambda pair: pair[0])
    if left > unit.enough:
        return []
    mend = f"were {mistaken} written? If not, all that is stated to yield does so otherwise"
    return [_remark(unit.what, left, mend)]


def _remark(what: str, left: float, mend: str) -> str:
    return f"{_with(what, left)}: {mend}"


def _refused(problem: Problem, mistake: Mistake, left: float) -> InputError:
    return InputError(Fault(str(problem.campaign.path), _with(mistake.what, left), mistake.mend))


def _with(what: str, left: float) -> str:
    return f"{what}, which leaves {np.sqrt(left):.0%} of the error"


def _mistakes(problem: Problem) -> Iterator[Mistake]:
    yield from _gravity(problem)
    c = problem.campaign
    used = np.unique(c.poses.payload)
    for order in permutations(used.tolist()) if 2 <= len(used) <= MOST else ():
        carried = np.array(order)[np.searchsorted(used, c.poses.payload)]
        if (carried == c.poses.payload).all():
            continue
        said = ", ".join(
            f"{called(c.payload_names[b])} where {called(c.payload_names[a])} is written"
            for a, b in zip(used, order, strict=True)
            if a != b
        )
        mend = "exchange the payloads' masses, or their names at the poses"
        stated = replace(problem, campaign=c.with_poses(payload=carried))
        yield Mistake(f"payload: the arm yields as under {said}", mend, stated, AGAINST)


def _gravity(problem: Problem) -> Iterator[Mistake]:
    """Gravity the other way round, and along the base's axes that it is not stated to be along."""
    g = problem.arm.gravity
    size = float(np.linalg.norm(g))
    ways = [way for way in size * np.vstack([np.eye(3), -np.eye(3)]) if np.abs(way @ g) < COSINE * size**2]
    for way in [-g, *ways] if size else ():
        there, here = (" ".join(f"{value:.2f}" for value in vector + 0.0) for vector in (way, g))
        what = f"gravity: the arm yields as under {there} m/s² on the base's axes, not {here}"
        mend = "say in the robot's TOML which way is down: `gravity`; on a ceiling or a wall it is another"
        yield Mistake(what, mend, replace(problem, arm=replace(problem.arm, gravity=way)), ALONG)


def _left(result: Fit, problem: Problem) -> float:
    """Squares that the fit leaves, to first order, where the loads are those of another problem."""
    normal = result.normal
    try:
        points = result.at(problem)
    except ArithmeticError:
        return np.inf
    moved = np.where(problem.seen[..., None], result.line.prediction.points - points, 0.0)
    by_points = result.whitener[:, :, : moved[0].size]
    r = result.r + np.matmul(by_points, moved.reshape(len(moved), -1, 1))[..., 0]
    if not np.isfinite(r).all():
        return np.inf
    again = normal.of_rows(r)
    return float((r**2).sum() + normal.offset @ normal.offset - again.gain(again.step(0.0).change))
