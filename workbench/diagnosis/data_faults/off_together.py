"""Poses that are far off in the way of a cause: they are no outliers, however few they are.

Of campaigns with a few poses from the other side, or under a load, the geometry fits the many; the few stand
out, and they are what tells the cause. And where a cause is plain in the many, the poses that were planned to
show it most are as far off as it says.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import betainc, chdtrc

from ...effects.unnamed import unnamed
from ...identification.fit import Fit
from ...identification.rows import offset_of
from ...robot.kinematics import Array
from ..candidates import testable
from ..priors import PRIORS
from .sag import sag

CHANCE = 1e-3  # that some cause explains as much of poses that are off by chance
MOSTLY = 0.5  # of a campaign: what is no outlier
EXPLAINED = 0.5  # of a pose's squares: what is no outlier
EXACT = 1e-9  # χ², or of it: data without noise
FREE = 3  # directions that a pose may be off in by chance, its points together

Poses = NDArray[np.bool_]


def no_outliers(result: Fit, wild: Poses) -> Poses:
    """(N,) of the wild poses (N,) those that are off in the way of a cause. result: a robust fit of the
    geometry.

    What depends on the time explains nothing here: an instrument that is disturbed for a while is no robot.
    """
    if not wild.any():
        return wild
    problem = result.model.problem
    candidates = [e for e in testable(problem)[0] if "time" not in e.uses]
    candidates += [e for e in unnamed(problem) if e.dated]  # what is otherwise in one of several campaigns
    columns = [result.whitened(e) * [p.typical for p in e.params] for e in candidates]
    sagging = sag(result)
    if sagging.shape[2]:
        columns.append(sagging)
    alike = _of_one_campaign(result, wild)
    return alike | _off_together(result, wild, columns) | _foreseen(result, wild, columns)


def _of_one_campaign(result: Fit, wild: Poses) -> Poses:
    """(N,) of the wild poses (N,) those of a campaign, of several that are fitted as one robot, that are most
    of it: its robot is another, or its zeros are, and no pose by itself is wrong."""
    campaign = result.model.problem.campaign
    if not campaign.beside:
        return np.zeros(len(wild), bool)
    setup = campaign.poses.setup
    share = np.bincount(setup, wild) / np.maximum(np.bincount(setup), 1)
    return np.asarray(wild & (share > MOSTLY)[setup])


def _off_together(result: Fit, wild: Poses, candidates: Sequence[Array]) -> Poses:
    """(N,) of the wild poses (N,) those that one cause explains. candidates: (N, D, p) columns of each.

    A cause of p numbers explains a share of the squares of n poses, each of which counts by its direction
    alone, that is by chance as large as one of Beta(p/2, (3n − p)/2).
    """
    out = np.zeros(len(wild), bool)
    if wild.sum() < 2:
        return out
    before = (result.r**2).sum(axis=1)
    J = (result.J * result.columns.prior).reshape(result.r.size, -1)
    for columns in candidates:
        after = (_left(result, J, columns) ** 2).sum(axis=1)
        share = 1 - float(after[wild].sum() / before[wild].sum())
        p, q = 0.5 * columns.shape[2], 0.5 * (FREE * wild.sum() - columns.shape[2])
        if share > 0 and q > 0 and betainc(q, p, 1 - share) * len(candidates) < CHANCE:
            out |= wild & (after < (1 - EXPLAINED) * before)
    return out


def _foreseen(result: Fit, wild: Poses, candidates: Sequence[Array]) -> Poses:
    """(N,) of the wild poses (N,) those that are off as foretold by causes that all other poses show by
    themselves: the likeliest one by one, as long as one takes more off χ² there than the best of as many
    would by chance. candidates: (N, D, p) columns of each."""
    sound = ~wild & result.model.problem.seen.any(axis=1)
    if not sound.any():
        return np.zeros(len(wild), bool)
    large = [PRIORS.largest * columns for columns in candidates]
    every = np.concatenate([result.J * result.columns.prior, *large], axis=2)
    ends = np.cumsum([result.J.shape[2], *(columns.shape[2] for columns in candidates)])
    parts = [np.arange(a, b) for a, b in pairwise(ends.tolist())]
    A, r = every[sound].reshape(-1, every.shape[2]), result.r[sound].ravel()
    gram, score = A.T @ A, A.T @ r
    held = score.copy()
    held[: ends[0]] -= offset_of(result.model, result.columns, result.state)
    fitted = np.arange(ends[0])
    while True:
        own = gram[np.ix_(fitted, fitted)]
        upper = np.linalg.cholesky(own + np.eye(len(own))).T
        z = solve_triangular(upper, held[fitted], trans="T", check_finite=False)
        size = solve_triangular(upper, z, check_finite=False)
        if not parts or 2 * len(fitted) > len(r):
            break
        Z = solve_triangular(upper, gram[fitted], trans="T", check_finite=False)
        left = held - Z.T @ z
        gains = []
        for part in parts:
            S = gram[np.ix_(part, part)] - Z[:, part].T @ Z[:, part] + np.eye(len(part))
            gains.append(float(left[part] @ np.linalg.solve(S, left[part])))
        best = int(np.argmax(gains))
        chi2 = float(r @ r - 2 * size @ score[fitted] + size @ own @ size)
        scatter = max(chi2 - gains[best], EXACT * chi2, EXACT) / (len(r) - len(fitted))
        if chdtrc(len(parts[best]), gains[best] / scatter) * len(parts) > CHANCE:
            break
        fitted = np.append(fitted, parts.pop(best))
    rest = result.r - every[:, :, fitted] @ size
    return np.asarray(wild & ((rest**2).sum(axis=1) < (1 - EXPLAINED) * (result.r**2).sum(axis=1)))


def _left(result: Fit, J: Array, columns: Array) -> Array:
    """(N, D) whitened residual with columns (N, D, p) in the fit, to first order. J: (N D, P) the
    fit's own in their priors."""
    G = columns.reshape(len(J), -1)
    Z = solve_triangular(result.upper, J.T @ G, trans="T", check_finite=False)
    S = G.T @ G - Z.T @ Z
    S[np.diag_indices_from(S)] += 1e-9 * max(float(np.trace(S)), 1.0)
    beta = np.linalg.solve(S, G.T @ result.r.ravel())
    moved = solve_triangular(result.upper, Z @ beta, check_finite=False)
    return np.asarray(result.r - (G @ beta - J @ moved).reshape(result.r.shape))
