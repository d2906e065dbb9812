"""Scatter from pose to pose that the noise does not hold, of single joints and of all targets together: a
variance, not a cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from ...identification.fit import Fit
from ...identification.noise import Covariance, body_motion
from ...identification.rows import whitening
from ...robot.kinematics import Array
from ..weighing.screen import effective_dof

CLEAR = 16.0  # twice the log likelihood from which a joint scatters: four standard deviations
TOGETHER = 8.0  # the same of all joints alike, or of a pose's targets together, which accuses no joint
SHOWN = 1e-2  # rad, m: what moves the points by less than the noise on such a way shows no scatter
LARGEST = 3e-2  # rad, m: no robot scatters by more
STEPS = 4  # of scoring to the likeliest variances


def with_scatter(fit: Fit, base: Covariance) -> Covariance:
    """The noise `base` with the scatter in a fit's residual, of the joints and of what carries the targets;
    the fit was made with that or more.

    What nobody recorded scatters so: the side that a play was left on, how the robot repeats (all its joints
    alike), and every other thing that acts on a whole pose. Were a pose's targets taken for as many
    independent witnesses, or the two places of a joint for a function of its angle, chance would look like a
    cause. Of all variances those stay without which the residual is clearly less likely, however few poses
    there are; that of all joints alike is tried before that of any. (How many of its own standard deviations
    a variance is says nothing: of N poses none is more than √(N/2).)"""
    motions, turning = _motions(fit, base), ~fit.model.problem.arm.prismatic
    n = len(turning)
    before = np.append(base.joint, base.body) ** 2
    had = np.maximum(np.append(fit.noise.joint, fit.noise.body) ** 2 - before, 0.0)
    common = min(had[:n][turning].tolist(), default=0.0)
    near = np.concatenate([had[:n] - common * turning, had[n:], [common]])
    clear = np.array([*np.full(n, CLEAR), TOGETHER, TOGETHER, TOGETHER])
    *single, all_alike = np.arange(n + 3).tolist()
    shown = motions.shown
    options = [_clear(motions, [k for k in shown if k in single], near, clear)]
    if all_alike in shown and not base.joint.any():  # else the base says how the robot repeats
        with_it = _clear(motions, shown, near, clear, pinned=all_alike)
        options.append(_clear(motions, np.flatnonzero(with_it[0]).tolist(), near, clear))
    extra, _ = max(options, key=lambda one: one[1] - clear[one[0] > 0].sum())
    own = extra[:-1] + extra[-1] * np.append(turning, [False, False])
    whole = before + np.minimum(own, LARGEST**2)
    *joint, shift, turn = np.sqrt(whole).tolist()
    return replace(base, joint=np.array(joint), body=(shift, turn))


def _clear(
    motions: _Motions, kept: Sequence[int], near: Array, clear: Array, pinned: int | None = None
) -> tuple[Array, float]:
    """The likeliest variances of those without which the residual is less likely by `clear`, and twice their
    log likelihood; the pinned one stays."""
    extra, gained = motions.likeliest(kept, near)
    while kept := [k for k in kept if extra[k] > 0 or k == pinned]:
        less = [motions.likeliest([k for k in kept if k != one], extra) for one in kept]
        missed = (gained - np.array([without for _, without in less])) / clear[kept]
        missed[[k == pinned for k in kept]] = np.inf
        least = int(np.argmin(missed))
        if missed[least] >= 1:
            break
        extra, gained = less[least]
        del kept[least]
    return extra, gained


def beyond_all(fit: Fit, base: Covariance) -> Array:
    """(n,) rad, m, what a fit's joints scatter by beyond another noise, and beyond what all that turn do
    alike."""
    turning = ~fit.model.problem.arm.prismatic
    extra = np.maximum(fit.noise.joint**2 - base.joint**2, 0.0)
    return np.asarray(np.sqrt(extra - turning * min(extra[turning].tolist(), default=0.0)))


@dataclass(frozen=True)
class _Motions:
    """Whitened motions of a pose's points, each with the sum of some of P variances. cross: (N, m, m) their
    products; score: (N, m) those with the residual; each: (P, m) 1 where a variance is one of a motion's."""

    cross: Array
    score: Array
    each: Array

    @property
    def own(self) -> Array:
        """(N, m) square lengths."""
        return np.asarray(np.einsum("nkk->nk", self.cross))

    @property
    def shown(self) -> list[int]:
        """Numbers of the variances of which the points show anything."""
        return np.flatnonzero(self.each @ (self.own.mean(axis=0) > SHOWN**-2)).tolist()

    def likeliest(self, among: Sequence[int], near: Array) -> tuple[Array, float]:
        """(P,) variances, none but some, and twice their log likelihood over that of none; from variances
        near (P,) by steps of E[(gᵀr)²] = |g|² + Σₖ (gᵀgₖ)² (σₖ² − cₖ²) for each motion g, where c² are the
        variances so far (Fisher's scoring)."""
        at = np.zeros(len(near))
        if not len(among):
            return at, 0.0
        at[among] = near[among]
        mine = self._some(np.asarray(self.each[among].any(axis=0)))
        each = mine.each[among]
        for _ in range(STEPS):
            now = mine.under(at)
            A = each @ (now.cross**2).sum(axis=0) @ each.T
            scale = 1 / np.sqrt(np.diag(A))
            b = scale * (each @ (now.score**2 - now.own).sum(axis=0))
            unit = max(float(np.abs(b).max()), 1e-30)  # the tolerance is absolute
            least = -at[among] / scale / unit
            bounds = least - 1e-9, np.inf
            step = lsq_linear(A * scale[:, None] * scale, b / unit, bounds=bounds, method="bvls").x
            at[among] = np.where(step > least + 1e-9, at[among] + unit * step * scale, 0.0)
        return at, mine.gained(at)

    def under(self, more: Array) -> _Motions:
        """The same whitened anew, by more of the variances (P,)."""
        both = np.concatenate([self.cross, self.score[..., None]], axis=2)
        solved = np.linalg.solve(self._held(more), both)
        return replace(self, cross=solved[..., :-1], score=solved[..., -1])

    def gained(self, more: Array) -> float:
        """Twice the log likelihood with more of the variances (P,) over that without."""
        held = self._held(more)
        under = np.linalg.solve(held, self.score[..., None])[..., 0]
        return float((self.score * (more @ self.each) * under).sum() - np.linalg.slogdet(held)[1].sum())

    def _held(self, more: Array) -> Array:
        return np.asarray(np.eye(self.each.shape[1]) + self.cross * (more @ self.each))

    def _some(self, columns: NDArray[np.bool_]) -> _Motions:
        cross = self.cross[:, columns][:, :, columns]
        return _Motions(cross, self.score[:, columns], self.each[:, columns])


def _motions(fit: Fit, noise: Covariance) -> _Motions:
    """Of a fit's joints, each and all alike; and shifts and turns of the body that carries a pose's targets,
    where these are measured by themselves; whitened by a noise. Of a single target a shift is noise that
    nobody stated."""
    problem = fit.model.problem
    W, g = _by_joint(fit, noise)
    n = g.shape[2]
    g = np.concatenate([g, W @ body_motion(problem)], axis=2)
    of = np.append(np.arange(n), np.repeat([n, n + 1], 3))
    turning = np.append(~problem.arm.prismatic, np.zeros(len(of) - n, bool))
    each = np.vstack([of == np.arange(n + 2)[:, None], turning]).astype(float)
    r = np.einsum("nde,ne->nd", W, np.nan_to_num(fit.residual).reshape(len(W), -1))
    free = fit.point_rows / max(effective_dof(fit), 1.0)
    return _Motions(g.transpose(0, 2, 1) @ g, np.einsum("ndk,nd->nk", g, r) * np.sqrt(free), each)


def _by_joint(fit: Fit, noise: Covariance) -> tuple[Array, Array]:
    """What whitens a pose's points (N, D, 3T), and their whitened motions by each joint (N, D, n)."""
    W = whitening(fit.model.problem, fit.line, noise)[:, :, : 3 * fit.model.problem.seen.shape[1]]
    return W, W @ fit.line.by_joint


def chi2_of_joints(fit: Fit, noise: Covariance, scatter: Array) -> Array:
    """(n,) what a scatter (n,) [rad, m] of each joint adds to χ² against a noise: E |W J δ|² = σ² |W J|²."""
    return np.asarray((_by_joint(fit, noise)[1] ** 2).sum(axis=(0, 1)) * scatter**2)


def alike(one: Covariance, other: Covariance) -> bool:
    """Whether two noises differ by less than a tenth: the instrument's, in any joint, and the body's."""
    pairs = (one.joint, other.joint), (one.body, other.body)
    robot = all(np.allclose(a, b, rtol=0.1, atol=1e-7) for a, b in pairs)
    return bool(robot and np.isclose(one.usual, other.usual, rtol=0.1))
