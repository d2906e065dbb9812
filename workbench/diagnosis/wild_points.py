"""Wild points, swapped and frozen targets: found on a robust geometry fit, mended or left out, and named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from ..campaign import Campaign
from ..campaign.problem import Problem
from ..effects.base import Effect
from ..identification.fit import Fit, fit
from ..identification.model import Model, State
from ..identification.noise import Covariance
from ..robot.kinematics import Array
from .result import FaultFound

WILD = 6.0  # robust standard deviations per axis from which a point is wild


Acting = tuple[tuple[Effect, Array], ...]


@dataclass(frozen=True)
class Cleaned:
    """The problem without its data faults, a robust geometry fit of it, and what was found."""

    problem: Problem
    fit: Fit
    faults: tuple[FaultFound, ...]


def clean(
    problem: Problem, start: State, noise: Covariance, known_effects: Acting = (), judged: bool = True
) -> Cleaned:
    """Finds data faults and mends them or leaves the points out."""
    faults: list[FaultFound] = []
    problem, frozen = _frozen(problem)
    faults += frozen
    for _ in range(4):
        result = robust_fit(problem, start, noise, known_effects)
        problem, found = _mend(problem, result, noise if judged else None)
        faults += found
        if not found:
            break
        start = result.state
    return Cleaned(problem, result, tuple(faults))


def robust_fit(problem: Problem, start: State, noise: Covariance, known_effects: Acting = ()) -> Fit:
    """Geometry fit in which a pose counts less the farther it is off (weights of Student's t, 4 dof)."""
    weight = noise.weight.copy()
    model = Model(problem, (), known_effects)
    for _ in range(6):
        result = fit(model, start, replace(noise, weight=weight), max_iterations=12)
        start = result.state
        size = _pose_size(result, weight)
        scale = float(np.median(size[weight > 0])) + 1e-12
        new = noise.weight * np.sqrt(5 / (4 + (size / scale) ** 2))
        if float(np.abs(new - weight).max()) < 0.02:
            break
        weight = new
    return result


def _pose_size(result: Fit, weight: Array) -> Array:
    """(N,) rms of the whitened residual of each pose, weights taken out."""
    r = result.point_residual
    rows = np.maximum((np.abs(result.whitener[:, : r.shape[1]]).sum(axis=2) > 0).sum(axis=1), 1)
    size = np.sqrt((r**2).sum(axis=1) / rows)
    return np.asarray(size / np.where(weight > 0, weight, 1.0))


def _mend(problem: Problem, result: Fit, noise: Covariance | None) -> tuple[Problem, list[FaultFound]]:
    """One round: outlier points, first tried as swapped targets."""
    length = np.linalg.norm(result.residual, axis=2)
    limit = _limit(length, noise)
    wild = np.where(np.isfinite(length), length > limit, False)
    if not wild.any():
        return problem, []
    c = problem.campaign
    points = c.points.copy()
    faults = []
    # the worst first: a wild point pulls its neighbours, so only what is near the worst goes now
    worst = np.nanmax(np.where(wild, length, 0.0) / limit, axis=1)
    top = worst.max()
    for n in np.flatnonzero(worst > max(1.0, 0.25 * top)):
        order = _swap(result, c, int(n), limit)
        if order is not None:
            points[n] = points[n][list(order)]
            names = [c.targets[i].name for i in range(len(order)) if order[i] != i]
            faults.append(
                FaultFound(
                    "swapped_target",
                    c.poses.ids[n],
                    " and ".join(names),
                    "targets exchanged",
                    "exchanged back",
                )
            )
            continue
        for i in np.flatnonzero(wild[n]):
            what = f"{length[n, i] * 1e3:.2f} mm off, others typically {np.nanmedian(length) * 1e3:.2f} mm"
            points[n, i] = np.nan
            target = c.targets[i].name if len(c.targets) > 1 else None
            faults.append(FaultFound("outlier", c.poses.ids[n], target, what, "left out"))
    return replace(problem, campaign=replace(c, points=points)), faults


def _limit(length: Array, noise: Covariance | None) -> Array:
    """(1, T) distance from which a point is wild: robust scale per target, never below the noise's."""
    middle = np.array([np.nanmedian(column) if np.isfinite(column).any() else np.inf for column in length.T])
    sigma = middle / 1.538  # median of a 3-D normal's length
    if noise is not None:
        sigma = np.maximum(sigma, np.nanmedian(noise.sigma, axis=0))
    return np.asarray(WILD * np.sqrt(3) * sigma)[None]


def _swap(result: Fit, c: Campaign, n: int, limit: Array) -> Sequence[int] | None:
    """The order of the targets that makes pose n fit; None when no exchange does."""
    n_targets = c.points.shape[1]
    if n_targets < 2 or n_targets > 5 or not np.isfinite(c.points[n]).all():
        return None
    predicted = result.line.prediction.points[n]
    for order in permutations(range(n_targets)):
        if list(order) == list(range(n_targets)):
            continue
        if (np.linalg.norm(c.points[n][list(order)] - predicted, axis=1) < limit[0]).all():
            return order
    return None


def _frozen(problem: Problem) -> tuple[Problem, list[FaultFound]]:
    """Points that repeat the pose before to the last digit although the joints have moved."""
    c = problem.campaign
    points = c.points.copy()
    faults = []
    for i, target in enumerate(c.targets):
        if problem.on[i] == 0:
            continue
        expected = problem.rigid.points(np.nan_to_num(problem.stated_targets), problem.on)[:, i]
        still = np.all(np.abs(np.diff(c.points[:, i], axis=0)) < 1e-9, axis=1)
        moved = np.linalg.norm(np.diff(expected, axis=0), axis=1) > 1e-3
        for n in np.flatnonzero(still & moved) + 1:
            points[n, i] = np.nan
            faults.append(
                FaultFound(
                    "frozen_target",
                    c.poses.ids[n],
                    target.name,
                    "same numbers as the pose before",
                    "left out",
                )
            )
    if not faults:
        return problem, []
    return replace(problem, campaign=replace(c, points=points)), faults
