"""Residuals of poses that a fit did not see."""

from __future__ import annotations

from collections.abc import Sequence
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky
from scipy.linalg.lapack import dpotri

from ..campaign.problem import Problem
from ..robot.kinematics import Array
from .fit import Fit

TELL_FRAME = 3  # positions of the arm that tell where the instrument stands from where the targets sit


def folds_of(problem: Problem, folds: int, seed: int) -> NDArray[np.int64]:
    """(N,) number of the group that each pose is held out with: joint positions drawn at random into groups
    of one size, so that a pose more or less leaves nearly all others where they were. Of set-ups with so few
    positions that without one nothing tells the instrument's frame from the targets, the loads are spread
    over the groups instead."""
    _, first, block = np.unique(problem.positions, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(problem.campaign.poses.drawn(seed)[first]))
    groups = min(folds, len(first))
    fold = np.asarray((rank * groups // len(first))[block.ravel()])
    for own in problem.campaign.poses.by_setup:
        if len(np.unique(block.ravel()[own])) <= TELL_FRAME:
            fold[own] = (fold[own[0]] + np.arange(len(own))) % groups
    return fold


def heldout(result: Fit, folds: int = 10, seed: int = 0, without: Sequence[int] = ()) -> Array:
    """Residuals (N, T, 3) [m] of each pose by a fit that did not see it (NaN where not seen).

    Poses with equal joints and set-up (their loads, their repeats) stay together. without: numbers of the
    model's effects that are left out, everything else fitted anew. The fits are Gauss–Newton steps from the
    full solution: exact to the second order of the change.
    """
    cols = result.columns
    out = np.array(result.residual)
    gone = [j for i in without for j in range(*cols.effect[i].indices(len(cols.names)))]
    to = -np.concatenate([np.zeros(0), *(result.state.values[i] for i in without)]) / cols.prior[gone]
    for here, step, inverse in _folds(result, folds, seed):
        held = inverse[:, gone]
        change = step - held @ np.linalg.solve(held[gone], step[gone] - to) if gone else step
        moved = result.motions.some(here).times(change * cols.prior)
        out[here] -= moved[:, : 3 * out.shape[1]].reshape(len(here), -1, 3)
    return out


Fold = tuple[NDArray[np.int64], Array, Array]
_kept: WeakKeyDictionary[Fit, dict[tuple[int, int], list[Fold]]] = WeakKeyDictionary()


def _folds(result: Fit, folds: int, seed: int) -> list[Fold]:
    """Of each group of poses: which, the step (P,) of the fit without them, in units of the priors, and the
    inverse (P, P) of its normal equations. Numbers that are held elsewhere follow from these: with Lagrange's
    multipliers, for the price of their own equations alone."""
    known = _kept.setdefault(result, {})
    if (folds, seed) not in known:
        fold = folds_of(result.model.problem, folds, seed)
        groups = [np.flatnonzero(fold == f).astype(np.int64) for f in range(int(fold.max()) + 1)]
        A, prior = result.upper.T @ result.upper, result.columns.prior
        known[folds, seed] = []
        for here in groups:
            own, right = result.normal.J.some(here).squares(result.r[here])
            inverse = inverse_of(without_rows(A, own * np.outer(prior, prior)))
            known[folds, seed].append((here, -inverse @ (right * prior), inverse))
    return known[folds, seed]


def inverse_of(A: Array) -> Array:
    """(P, P) inverse of normal equations."""
    upper = np.triu(dpotri(cholesky(A, check_finite=False))[0])
    return np.asarray(upper + np.triu(upper, 1).T)


def without_rows(A: Array, own: Array) -> Array:
    """(P, P) normal equations A less those of some rows (P, P)."""
    left = A - own
    left[np.diag_indices_from(left)] += 1e-12 * np.diag(A)
    return np.asarray(left)
