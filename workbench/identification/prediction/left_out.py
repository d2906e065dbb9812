"""Errors and their covariances at poses that a fit did not see: what bounds are measured by.

Of points, or of the turns of a tool that is measured as a pose: [m] reads [rad] then.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from ...robot.kinematics import Array
from ..fit import Fit
from ..heldout import folds_of, without_rows
from ..rows import whitening
from .tool import turns_of

FOLDS = 10
PARTS = 5  # of the campaign, one after the other
CENTRES = 10  # of regions
SHARES = (0.2, 0.4)  # of the poses that a region has
END = 0.15  # share of the positions that lie at an end of a joint's range
RIGID = 3  # points that say how a tool is turned


@dataclass(frozen=True)
class LeftOut:
    """Points of poses that a fit did not see, k of them.

    error: (k, 3) [m] measured minus predicted; fitted: (k, 3, 3) [m²] covariance by that fit's numbers;
    scatter: (k, 3, 3) by the joints; seen: (k, 3, 3) by the instrument; beyond: (k,) [rad, 1/3 m]
    how far a joint is outside of what that fit saw; pose: (k,) which one.
    """

    error: Array
    fitted: Array
    scatter: Array
    seen: Array
    beyond: Array
    pose: NDArray[np.int64]

    @property
    def inside(self) -> LeftOut:
        """Those that lie inside of what their fit saw."""
        here = self.beyond == 0
        return LeftOut(*(getattr(self, name)[here] for name in LeftOut.__annotations__))


@dataclass(frozen=True)
class Apart:
    """Points `which` (k,) of all that are looked at, as a fit without their poses has them: but for `fitted`,
    and its normal equations A (P, P), in units of the priors."""

    which: NDArray[np.int64]
    out: LeftOut
    A: Array


class Leaver:
    """Leaves poses out of a fit, again and again. points: (T,) which targets are looked at; turns: not where
    they are, but how the tool that carries them is turned."""

    def __init__(self, fit: Fit, points: NDArray[np.bool_], turns: bool = False) -> None:
        self.fit = fit
        count, targets = fit.residual.shape[:2]
        used = fit.model.problem.seen & points & (fit.noise.weight > 0)[:, None]
        turned = turns_of(fit.line.prediction.points, used) if turns else np.zeros(0)
        if turns:
            used = used.sum(axis=1, keepdims=True) >= RIGID

        def looked_at(motions: Array) -> Array:
            """(N, T or 1, 3, k) of the points' (N, 3 T, k)."""
            return (turned @ motions)[:, None] if turns else motions.reshape(count, targets, 3, -1)

        self.pose, of = np.nonzero(used)
        self.plain = looked_at((fit.motions.columns * fit.columns.prior)[:, : 3 * targets])[self.pose, of]
        self.error = looked_at(np.nan_to_num(fit.residual).reshape(count, -1, 1))[self.pose, of, :, 0]
        self.J = fit.J * fit.columns.prior
        self.A = fit.upper.T @ fit.upper
        noise = (_squared(looked_at(half)) for half in _noise(fit))
        self.seen, self.scatter = (each[self.pose, of] for each in noise)

    def leave(self, here: NDArray[np.bool_], beyond: Array, variance: float) -> LeftOut:
        """The poses `here` (N,) left out; beyond: (N,) as in `LeftOut`; variance: as in `tempered`."""
        apart = self._apart(here)
        return replace(self._at(variance, apart), beyond=beyond[apart.out.pose])

    def _apart(self, here: NDArray[np.bool_]) -> Apart:
        own = self.J[here].reshape(-1, self.J.shape[2])
        left = without_rows(self.A, own.T @ own)
        change = -np.linalg.solve(left, own.T @ self.fit.r[here].ravel())
        which = np.flatnonzero(here[self.pose])
        error, seen = self.error[which] - self.plain[which] @ change, self.seen[which]
        out = LeftOut(error, 0 * seen, self.scatter[which], seen, np.zeros(len(which)), self.pose[which])
        return Apart(which, out, left)

    def _at(self, variance: float, apart: Apart) -> LeftOut:
        lower = np.linalg.cholesky(tempered(apart.A, variance))
        plain = self.plain[apart.which].reshape(-1, len(lower))
        half = solve_triangular(lower, plain.T, lower=True, check_finite=False).T.reshape(-1, 3, len(lower))
        return replace(apart.out, fitted=_squared(half))

    @cached_property
    def _positions(self) -> list[Apart]:
        fold = folds_of(self.fit.model.problem, FOLDS, seed=0)
        return [self._apart(fold == f) for f in range(fold.max() + 1)]

    @cached_property
    def _regions(self) -> list[Apart]:
        return [self._apart(here) for here in regions(self.fit.model.problem.q)]

    def by_position(self, variance: float) -> LeftOut:
        """Every pose once, in groups of positions drawn at random."""
        return joined([self._at(variance, apart) for apart in self._positions])

    def by_part(self, variance: float) -> LeftOut:
        """The poses of each part of the campaign, in the order of measurement within its set-ups: a part may
        stand elsewhere than its neighbours, and later."""
        problem = self.fit.model.problem
        part = np.zeros(len(problem.q), dtype=np.int64)
        for own in problem.campaign.poses.by_setup:
            part[own] = np.arange(len(own)) * PARTS // len(own)
        unit, out = np.where(problem.arm.prismatic, 3.0, 1.0), []
        for k in range(PARTS):
            others = problem.q[part != k]
            low, high = others.min(axis=0), others.max(axis=0)
            beyond = (np.maximum(low - problem.q, problem.q - high) * unit).max(axis=1)
            out.append(self.leave(part == k, np.maximum(beyond, 0.0), variance))
        return joined(out)

    def by_region(self, variance: float) -> list[LeftOut]:
        """The poses of each region of joint space, a corner among others: see `regions`."""
        return [self._at(variance, apart) for apart in self._regions]

    def by_end(self, variance: float) -> Iterator[LeftOut]:
        """The poses at each end of each joint's range."""
        problem = self.fit.model.problem
        unit = np.where(problem.arm.prismatic, 3.0, 1.0)
        for x in (problem.q * unit).T:
            for side in (x, -x):
                edge = float(np.quantile(side, 1 - END))
                here = side > edge
                if here.any() and not here.all() and np.ptp(side[~here]) > 0:
                    yield self.leave(here, np.maximum(side - side[~here].max(), 0.0), variance)


def regions(q: Array) -> Iterator[NDArray[np.bool_]]:
    """Neighbours (N,) in joint space, joints in units of their spread: around each of `CENTRES` poses, as far
    apart as can be, the nearest `SHARES` of q (N, n) [rad, m]."""
    spread = q.std(axis=0)
    x = (q - q.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    nearest = np.full(len(x), np.inf)
    centre = int(np.linalg.norm(x, axis=1).argmax())
    for _ in range(CENTRES):
        away = np.linalg.norm(x - x[centre], axis=1)
        for share in SHARES:
            yield away <= np.quantile(away, share)
        nearest = np.minimum(nearest, away)
        centre = int(nearest.argmax())


def tempered(A: Array, variance: float) -> Array:
    """(P, P) normal equations in units of the priors; variance: of the data, over the noise's."""
    eye = np.eye(len(A))
    return np.asarray((A - eye) / variance + eye)


def joined(parts: list[LeftOut]) -> LeftOut:
    """All of them, one after the other."""
    return LeftOut(*(np.concatenate([getattr(p, name) for p in parts]) for name in LeftOut.__annotations__))


def _noise(fit: Fit) -> tuple[Array, Array]:
    """(N, 3 T, k) [m] square roots of the points' covariances: by the instrument, and by the joints'
    repeatability."""
    rows = 3 * fit.residual.shape[1]
    scatter = fit.line.by_joint * fit.noise.joint
    sigma = np.asarray(np.repeat(fit.noise.sigma, 3, axis=1)[..., None] * np.eye(rows))
    if fit.model.problem.campaign.six_dof:
        alone = replace(fit.noise, joint=np.zeros_like(fit.noise.joint))
        W = whitening(fit.model.problem, fit.line, alone)[:, : fit.point_residual.shape[1], :rows]
        sigma = np.asarray(np.linalg.pinv(W))
    return sigma, np.asarray(scatter)


def _squared(half: Array) -> Array:
    """(..., 3, 3) covariances of square roots (..., 3, k)."""
    return np.asarray(half @ half.swapaxes(-1, -2))
