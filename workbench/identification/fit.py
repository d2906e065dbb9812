"""Identification: Gauss–Newton on analytic Jacobians, whitened by the noise, held by wide priors.

Geometry corrections carry a prior of a few mm and mrad, which is far wider than what data decide and
keeps what they cannot decide at its nominal value: no columns are chosen by hand, nothing runs off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve, qr, solve_triangular
from scipy.spatial.transform import Rotation

from ..campaign.problem import Problem
from ..effects.base import Effect
from ..robot.kinematics import Array
from .model import Linearisation, Model, State, move_frame
from .noise import Covariance, required_noise, whitener
from .parameters import Columns, body_motion, columns
from .registration import register


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    line: derivatives at the solution; whitener: (N, D, R) with R = 3T, or 3T + n where drive torques were
    recorded; J: (N, D, P) whitened Jacobian, r: (N, D) whitened residual (measured minus predicted);
    residual: (N, T, 3) [m], NaN where not seen.
    upper: (P, P) with (JᵀJ + prior)= upperᵀ upper, in units of the priors.
    """

    model: Model
    state: State
    columns: Columns
    noise: Covariance
    line: Linearisation
    whitener: Array
    J: Array
    r: Array
    residual: Array
    upper: Array
    iterations: int

    @property
    def covariance(self) -> Array:
        """(P, P) covariance of the fitted numbers."""
        half = solve_triangular(self.upper, np.eye(len(self.upper))).T * self.columns.prior
        return np.asarray(half.T @ half)

    @property
    def rank(self) -> int:
        """Number of combinations that the data decide better than their prior does."""
        return int((np.linalg.svd(self.upper, compute_uv=False) > np.sqrt(2)).sum())

    @property
    def chi2(self) -> float:
        """Whitened residual sum of squares of the points."""
        return float((self.point_residual**2).sum())

    @property
    def point_residual(self) -> Array:
        """(N, D') whitened residual of the points alone, without the drive torques."""
        return self.r[:, : self.r.shape[1] - self.model.problem.drives]

    @property
    def point_rows(self) -> int:
        """Number of whitened rows that carry data of points."""
        used = np.abs(self.whitener[:, : self.point_residual.shape[1]]).sum(axis=2) > 0
        return int(used.sum())

    def effect_values(self, i: int) -> tuple[Array, Array]:
        """Values (p,) and covariance (p, p) of the model's i-th effect."""
        part = self.columns.effect[i]
        return self.state.values[i], self.covariance[part, part]

    def wald(self, i: int) -> float:
        """Squared size of the model's i-th effect in standard deviations."""
        values, covariance = self.effect_values(i)
        return float(values @ np.linalg.solve(covariance, values))


def start_state(problem: Problem) -> State:
    """State after registration, robot as it is."""
    R, t, targets = register(problem)
    return State(problem.arm.geometry, R, t, targets)


def fit(
    model: Model,
    start: State | None = None,
    noise: Covariance | None = None,
    geometry: bool | Sequence[int] = True,
    tolerance: float = 1e-2,
    max_iterations: int = 30,
) -> Fit:
    """Fits frames, targets, geometry and the model's effects to the campaign.

    geometry: all of it, none of it, or only the columns 6 · slot + component (tx ty tz rx ry rz) named.
    start: default the registered nominal robot; it may lack the effects' values (zeros then). noise: default
    as the campaign states it. Stops when a step changes no fitted number by more than `tolerance` of its
    standard deviation. Raises ArithmeticError when it does not converge, `InputError` without any noise.
    """
    problem = model.problem
    start, noise = start or start_state(problem), noise or required_noise(problem)
    if len(start.values) != len(model.effects):
        start = replace(start, values=tuple(np.zeros(len(e.params)) for e in model.effects))
    cols = columns(problem, model.effects, geometry)
    state, damping = start, 0.0
    near: Linearisation | None = None
    W, step, halved = np.zeros(0), np.zeros(0), 0
    best: tuple[float, State] | None = None
    for iteration in range(max_iterations):
        try:
            line = model.linearise(state, near)
        except ArithmeticError:  # the step went to an arm too soft to stand: half of it, and half again
            if best is None or near is None or halved > 20:
                raise
            halved += 1
            state = _move(problem, cols, best[1], near.centre, 0.5**halved * step)
            continue
        near, halved = line, 0
        if iteration < 2:
            W = _whitener(problem, line, noise)
        residual, r = _residual(model, line, state, W)
        offset = _offset(model, cols, state)
        cost = float((r**2).sum() + (offset**2).sum())
        if best is not None and cost > best[0] * (1 + 1e-6) + 1e-3 and iteration > 2:
            damping = max(10 * damping, 1e-2)
            if damping > 1e8:
                raise ArithmeticError("the fit does not converge")
            cost, state = best[0], best[1]
            line = model.linearise(state, near)
            residual, r = _residual(model, line, state, W)
            offset = _offset(model, cols, state)
        else:
            damping = damping / 10 if damping > 1e-9 else 0.0
        best = cost, state
        J = _jacobian(model, line, cols, state, W)
        flat = J.reshape(-1, J.shape[2])
        step, moved = _quick_step(flat, r.ravel(), offset, cols.prior, damping)
        if moved < tolerance and damping == 0.0:
            break
        state = _move(problem, cols, state, line.centre, step)
    if halved and best is not None:
        state = best[1]
    upper = _step(flat, r.ravel(), offset, cols.prior, 0.0)[1]
    seen = problem.seen[..., None]
    return Fit(
        model, state, cols, noise, line, W, J, r, np.where(seen, residual, np.nan), upper, iteration + 1
    )


def refit(result: Fit, effects: Sequence[Effect]) -> Fit:
    """The same data with other effects, started from the numbers that a fit has already."""
    had = dict(zip(result.model.effects, result.state.values, strict=True))
    values = tuple(had.get(effect, np.zeros(len(effect.params))) for effect in effects)
    model = replace(result.model, effects=tuple(effects))
    return fit(model, replace(result.state, values=values), result.noise, max_iterations=12)


def _whitener(problem: Problem, line: Linearisation, noise: Covariance) -> Array:
    axial = line.direct[:, : 3 * problem.seen.shape[1], problem.arm.axial]
    turned = None
    if problem.campaign.six_dof:
        points = line.prediction.points
        seen = problem.seen[..., None]
        middle = np.where(seen, points, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
        turned = points - middle[:, None]
    W = whitener(problem, noise, axial, turned)
    if not problem.drives:
        return W
    n_poses, rows, columns_ = W.shape
    out = np.zeros((n_poses, rows + problem.drives, columns_ + problem.drives))
    out[:, :rows, :columns_] = W
    if noise.torque is not None and problem.campaign.torque is not None:
        weight = np.isfinite(problem.campaign.torque) / noise.torque * noise.weight[:, None]
        for j in range(problem.drives):
            out[:, rows + j, columns_ + j] = weight[:, j]
    return out


def _residual(model: Model, line: Linearisation, state: State, W: Array) -> tuple[Array, Array]:
    """Measured minus predicted (N, T, 3), zero where not seen, and whitened (N, D)."""
    problem, points = model.problem, line.prediction.points
    residual = np.where(problem.seen[..., None], problem.campaign.points - points, 0.0)
    flat = residual.reshape(len(residual), -1)
    if problem.drives:
        flat = np.concatenate([flat, model.drive_residual(line, state)], axis=1)
    return residual, np.matmul(W, flat[..., None])[..., 0]


def _offset(model: Model, cols: Columns, state: State) -> Array:
    """How far each number is from its prior's mean, in units of the prior."""
    problem = model.problem
    out = np.zeros(len(cols.names))
    for k, i, part in cols.targets:
        off = state.targets[k] - problem.stated_targets
        if i is not None:
            out[part] = np.nan_to_num(off[i])
        elif np.isfinite(off).all():
            out[part] = np.linalg.lstsq(body_motion(state.targets[k]), off.ravel(), rcond=None)[0]
    change = state.geometry - problem.arm.geometry
    out[cols.geometry_slice] = change.ravel()[cols.geometry]
    for part, values in zip(cols.effect, state.values, strict=True):
        out[part] = values
    return out / cols.prior


def _jacobian(model: Model, line: Linearisation, cols: Columns, state: State, W: Array) -> Array:
    """(N, D, P) whitened Jacobian."""
    setup = model.problem.campaign.setup
    n_poses, rows, _ = line.direct.shape
    J = np.zeros((n_poses, rows, len(cols.names)))
    for k in range(cols.setups):
        J[:, :, 6 * k : 6 * k + 6] = np.where((setup == k)[:, None, None], line.frame, 0.0)
    for k, i, part in cols.targets:
        here = (setup == k)[:, None, None]
        if i is not None:
            J[:, 3 * i : 3 * i + 3, part] = np.where(here, line.target[:, i], 0.0)
        else:
            body = body_motion(state.targets[k]).reshape(-1, 3, 6)
            count = 3 * line.target.shape[1]
            J[:, :count, part] = np.where(here, (line.target @ body).reshape(n_poses, count, 6), 0.0)
    J[:, :, cols.geometry_slice] = line.geometry[:, :, cols.geometry]
    for part, effect, values in zip(cols.effect, model.effects, state.values, strict=True):
        J[:, :, part] = model.effect_jacobian(line, effect, values)
    return np.asarray(np.matmul(W, J))


def _quick_step(J: Array, r: Array, offset: Array, prior: Array, damping: float) -> tuple[Array, float]:
    """Step and its length in standard deviations, by the normal equations (scaled, then Cholesky);
    by QR where these are too nearly singular."""
    A = (J.T @ J) * np.outer(prior, prior)
    A[np.diag_indices_from(A)] += 1.0
    g = (J.T @ r) * prior - offset
    scale = 1 / np.sqrt(np.diag(A))
    M = A * np.outer(scale, scale)
    M[np.diag_indices_from(M)] *= 1 + damping
    try:
        step = scale * cho_solve(cho_factor(M, check_finite=False), scale * g)
    except np.linalg.LinAlgError:
        step = _step(J, r, offset, prior, damping)[0] / prior
    return step * prior, float(np.sqrt(max(float(step @ A @ step), 0.0)))


def _step(J: Array, r: Array, offset: Array, prior: Array, damping: float) -> tuple[Array, Array]:
    """Step of all numbers and the triangular factor, by QR of the data's and the priors' rows."""
    P = len(prior)
    stacked = np.vstack([J * prior, np.eye(P)])
    right = np.concatenate([r, -offset])
    if damping > 0:
        scale = np.sqrt(damping) * np.linalg.norm(stacked, axis=0)
        stacked = np.vstack([stacked, np.diag(scale)])
        right = np.concatenate([right, np.zeros(P)])
    QtR, upper = _qr(stacked, right)
    return np.asarray(solve_triangular(upper, QtR) * prior), upper


def _qr(A: Array, b: Array) -> tuple[Array, Array]:
    """Qᵀ b (P,) and R (P, P) of A = Q R, from one triangular factor of [A b]."""
    P = A.shape[1]
    factor = qr(np.column_stack([A, b]), mode="r", overwrite_a=True, check_finite=False)[0]
    R = np.asarray(factor, dtype=np.float64)
    return R[:P, P], R[:P, :P]


def _move(problem: Problem, cols: Columns, state: State, centre: Array, step: Array) -> State:
    """The state after a step."""
    for k in range(cols.setups):
        state = move_frame(state, k, centre[k], step[6 * k : 6 * k + 6])
    targets = state.targets.copy()
    for k, i, part in cols.targets:
        if i is not None:
            targets[k, i] += step[part]
            continue
        centre = targets[k].mean(axis=0)
        turn = Rotation.from_rotvec(step[part][3:])
        targets[k] = turn.apply(targets[k] - centre) + centre + step[part][:3]
    geometry = state.geometry.copy()
    geometry.reshape(-1)[cols.geometry] += step[cols.geometry_slice]
    values = tuple(v + step[part] for v, part in zip(state.values, cols.effect, strict=True))
    return replace(state, targets=targets, geometry=geometry, values=values)


def heldout(result: Fit, folds: int = 10, seed: int = 0) -> Array:
    """Residuals (N, T, 3) [m] of each pose by a fit that did not see it (NaN where not seen).

    Poses with equal joints and set-up (their loads, their repeats) stay together. The fits without a
    fold are Gauss–Newton steps from the full solution: exact to the second order of the change.
    """
    problem, cols = result.model.problem, result.columns
    block = problem.positions
    blocks = int(block.max()) + 1
    fold = (np.random.default_rng(seed).permutation(blocks) % min(folds, blocks))[block]
    plain = _jacobian(
        result.model, result.line, cols, result.state, _unit(result.whitener.shape[2], len(block))
    )
    A = result.upper.T @ result.upper
    out = result.residual.copy()
    for f in range(fold.max() + 1):
        here = fold == f
        J = result.J[here].reshape(-1, len(cols.names)) * cols.prior
        r = result.r[here].ravel()
        left = A - J.T @ J
        left[np.diag_indices_from(left)] += 1e-12 * np.diag(A)
        change = np.linalg.solve(left, -(J.T @ r)) * cols.prior
        out[here] -= (plain[here] @ change)[:, : 3 * out.shape[1]].reshape(here.sum(), -1, 3)
    return out


def _unit(rows: int, n_poses: int) -> Array:
    return np.broadcast_to(np.eye(rows), (n_poses, rows, rows))
