"""Noise of a campaign: the instrument's per point, and the robot's repeatability per pose.

A pose's points share the robot's own error: their covariance is  σ² I + J Σ_q J^T + B Σ_b B^T  with Σ_q the
joints' repeatability and Σ_b that of the body that carries them, where more than the joints moves it.
Points of one 6-D measurement carry six independent errors, not three each.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from ..campaign.problem import Problem
from ..files.faults import Fault, InputError
from ..robot.kinematics import Array
from ..robot.rotations import body_jacobian
from .repeats import scatter_of_repeats

NOTHING = 2 * np.log(1e-12)  # logarithm of a variance [m² or rad²] that is none
FEWEST_DOF = 12  # degrees of freedom from which repeats or shots show a noise
EXACT = 1e-12  # of the largest: what is less is rounding
LEAST = 1e-6  # m: no instrument that sees a robot is better; a fit that believes one bends to what it rounds


@dataclass(frozen=True)
class Covariance:
    """Noise of the measured points.

    sigma: (N, T) [m] per axis; joint: (n,) [rad or m] one sigma of the joints' repeatability; weight:
    (N,) factor on each pose (0 leaves it out). dof: degrees of freedom behind the noise (inf: known).
    turn_ratio: for 6-D measurements, noise of the turning part over that which points of the shifting part's
    would make; about: target at which both are independent, -1 the middle of all: shifts of an instrument's
    own origin do not know how its turns move the points beside it.
    torque: (n,) one sigma of the drive torques [N·m, N], infinite where they say nothing; None: unused.
    body: one sigma of shifts [m] and turns [rad] of the points on a pose's last body, all together.
    """

    sigma: Array
    joint: Array
    weight: Array
    dof: float = np.inf
    turn_ratio: float = 1.0
    about: int = -1
    torque: Array | None = None
    body: tuple[float, float] = (0.0, 0.0)

    @property
    def usual(self) -> float:
        """The instrument's sigma per axis [m], over all points (root mean square)."""
        return float(np.sqrt(np.mean(self.sigma**2)))

    def times(self, factor: float) -> Covariance:
        """The noise of points and joints larger by a factor."""
        body = factor * self.body[0], factor * self.body[1]
        return replace(self, sigma=factor * self.sigma, joint=factor * self.joint, body=body)

    def some(self, poses: NDArray[np.int64]) -> Covariance:
        """Of these poses alone."""
        return replace(self, sigma=self.sigma[poses], weight=self.weight[poses])


def stated_noise(problem: Problem) -> Covariance | None:
    """Noise as the campaign and the robot state it; None where the campaign states none."""
    c = problem.campaign
    joint = problem.robot.repeatability
    if c.sigma is not None and np.isfinite(c.sigma[problem.seen]).any():
        sigma = np.sqrt(np.nanmean(np.where(np.isfinite(c.sigma), c.sigma, np.nan)[problem.seen] ** 2))
        each = np.where(problem.seen, np.sqrt(np.mean(np.nan_to_num(c.sigma, nan=sigma) ** 2, axis=2)), sigma)
        if c.noise_sigma is None and not np.isfinite(c.sigma[problem.seen]).all():
            each = np.where(np.isfinite(c.sigma).all(axis=2), each, sigma)
    elif c.noise_sigma is not None:
        each = c.noise_sigma / np.sqrt(np.maximum(c.shots, 1))
    else:
        return None
    return Covariance(np.maximum(each, LEAST), joint, np.ones(len(c.poses.q)))


def required_noise(problem: Problem) -> Covariance:
    """Noise as stated; raises `InputError` where the campaign states none."""
    noise = stated_noise(problem)
    if noise is None:
        raise InputError(Fault(problem.campaign.title, "states no noise", "say sigma_mm under [noise]"))
    return noise


def whitener(problem: Problem, covariance: Covariance, axial: Array | None, turned: Array | None) -> Array:
    """(N, D, 3T): whitens residuals (N, 3T) of a pose; rows of what was not seen are zero.

    axial: (N, 3T, n) motion of the points per joint motion, None where the joints scatter nothing. turned:
    (N, T, 3) the points from their centroid, in the instrument's frame, for 6-D measurements (D = 6); None
    else (D = 3T).
    """
    seen = np.repeat(problem.seen, 3, axis=1)
    n_poses, rows = seen.shape
    sigma = np.repeat(covariance.sigma, 3, axis=1)
    if turned is not None:
        W = _six(problem, covariance, axial, turned)
    elif not covariance.joint.any() and not any(covariance.body):
        W = np.zeros((n_poses, rows, rows))
        W[:, np.arange(rows), np.arange(rows)] = np.where(seen, 1 / sigma, 0.0)
    else:
        J = np.zeros((n_poses, rows, 0))
        if axial is not None:
            J = np.where(seen[..., None], axial, 0.0) * covariance.joint
        if any(covariance.body):
            J = np.concatenate([J, body_motion(problem) * np.repeat(covariance.body, 3)], axis=2)
        C = J @ J.transpose(0, 2, 1)
        C[:, np.arange(rows), np.arange(rows)] += np.where(seen, sigma**2, 1.0)
        L = np.linalg.cholesky(C)
        W = np.linalg.inv(L) * seen[:, None, :] * seen[:, :, None]
    return np.asarray(W * covariance.weight[:, None, None])


def log_precision(W: Array) -> float:
    """Half the log determinant of the data's precision, of a whitener (N, D, K): triangular, or of the six
    motions of a 6-D measurement."""
    if W.shape[1] == W.shape[2]:
        size = np.abs(np.einsum("nkk->nk", W))
    else:
        size = np.linalg.svd(W, compute_uv=False)
        size = np.where(size > EXACT * size.max(axis=1, keepdims=True), size, 0.0)
    return float(np.log(size[size > 0]).sum())


def body_motion(problem: Problem) -> Array:
    """(N, 3T, 6) motion of the points on a pose's last body per its shift and turn about their centroid; 0 of
    others, and of what was not seen."""
    on = np.array(problem.on)
    mine = problem.seen & (on == on.max())
    at = np.where(mine[..., None], problem.campaign.points, 0.0)
    middle = at.sum(axis=1, keepdims=True) / np.maximum(mine.sum(axis=1), 1)[:, None, None]
    motion = np.where(mine[..., None, None], body_jacobian(at - middle), 0.0)
    return np.asarray(motion.reshape(len(mine), -1, 6))


def _six(problem: Problem, covariance: Covariance, axial: Array | None, turned: Array) -> Array:
    """The six motions of a rigid pose, shifts before turns, each with its own noise, whitened with what the
    joints and the body that carries the targets scatter."""
    seen = problem.seen
    count = seen.sum(axis=1)
    whole = count >= 3
    own = turned if covariance.about < 0 else turned - turned[:, covariance.about, None]
    A = np.where(seen[..., None, None], body_jacobian(own), 0.0).reshape(len(own), -1, 6)
    square = A.transpose(0, 2, 1) @ A
    least = np.where(whole, EXACT * np.trace(square, axis1=1, axis2=2), 1.0)
    motions = np.linalg.solve(square + least[:, None, None] * np.eye(6), A.transpose(0, 2, 1))
    sigma = np.maximum(np.where(seen, covariance.sigma, 0.0).sum(axis=1) / np.maximum(count, 1), 1e-12)
    turn = np.where(whole, covariance.turn_ratio * turn_of_points(problem, turned), 1.0)
    scale = sigma[:, None] * np.repeat(np.stack([np.ones_like(turn), turn], axis=1), 3, axis=1)
    W = motions / scale[:, :, None]
    J = np.zeros((*W.shape[:2], 0)) if axial is None else W @ (axial * covariance.joint)
    if any(covariance.body):
        J = np.concatenate([J, W @ (body_motion(problem) * np.repeat(covariance.body, 3))], axis=2)
    if J.any():
        W = np.linalg.solve(np.linalg.cholesky(np.eye(6) + J @ J.transpose(0, 2, 1)), W)
    return np.asarray(np.where(whole[:, None, None], W, 0.0))


def turn_of_points(problem: Problem, turned: Array) -> Array:
    """(N,) [rad/m] by which a pose would turn about each axis per noise of points (N, T, 3) from their
    middle, were they as far from it in all directions."""
    seen = problem.seen[..., None]
    square = np.where(seen, turned, 0.0)
    size = 2 * (square**2).sum(axis=(1, 2))
    return np.asarray(np.sqrt(3 * problem.seen.sum(axis=1) / np.where(size > 0, size, np.inf)))


@dataclass(frozen=True)
class MeasuredNoise:
    """Noise from repeats and shots. sigma [m] per axis and shot; joint: (n,) one sigma per
    joint; total [m] per axis of a repeated point; dof of each."""

    sigma: float
    joint: Array
    total: float
    dof: float


def measure_noise(problem: Problem, axial: Array) -> MeasuredNoise | None:
    """Noise from repeated poses and shots; None where there are fewer than `FEWEST_DOF`.

    axial: (N, 3T, n) motion of the points per joint motion. Maximum likelihood of two variances: the
    instrument's σ² and one for the joints (their ratio as the robot's TOML says, else equal).
    """
    c = problem.campaign
    deviation, weight, dof = scatter_of_repeats(problem)
    shot_ss, shot_dof = c.shot_scatter
    if dof < FEWEST_DOF:
        return None
    kept = (weight > 0).any(axis=1)
    seen_again = np.repeat(weight[kept] > 0, 3, axis=1)
    d = deviation.reshape(len(weight), -1)[kept]
    ratio = problem.robot.repeatability
    ratio = ratio / ratio.max() if ratio.any() else np.where(problem.arm.prismatic, 0.0, 1.0)
    J = axial[kept] * ratio * seen_again[..., None]
    total = max(float(np.sqrt((d**2).sum() / dof)), 1e-9)
    # deviations from a group's mean of k members have covariance (1 − 1/k) of the noise's, at most
    d = d / np.sqrt(np.where(seen_again, np.repeat(weight[kept], 3, axis=1), 1.0))
    share = weight[kept].sum(axis=1) / (weight[kept] > 0).sum(axis=1)
    shots = float(np.median(c.shots[problem.seen])) if problem.seen.any() else 1.0
    reach = float(np.sqrt((J**2).sum() / max(1, J.shape[0] * J.shape[1])))
    u, s, _ = np.linalg.svd(J, full_matrices=False)
    projected = np.einsum("nij,ni->nj", u, d)
    rest = (d**2).sum(axis=1) - (projected**2).sum(axis=1)
    free = seen_again.sum(axis=1) - u.shape[2]

    def cost(x: Array) -> float:
        x = np.maximum(x, NOTHING)
        v_m, v_q = np.exp(x[0]) / shots, np.exp(x[1])
        v = v_m + v_q * s**2
        value = share @ (np.sum(np.log(v) + projected**2 / v, axis=1) + rest / v_m + free * np.log(v_m))
        if shot_dof > 0:
            value += shot_dof * np.log(np.exp(x[0])) + shot_ss / np.exp(x[0])
        return float(value)

    start = np.log([0.5 * total**2 * shots, 0.5 * total**2 / max(reach, 1e-9) ** 2])
    x = minimize(cost, start, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-6}).x
    joint = float(np.exp(x[1] / 2)) * ratio
    if float(np.exp(x[1] / 2)) * reach < 0.03 * total:
        joint = np.zeros_like(joint)
    return MeasuredNoise(
        max(float(np.exp(x[0] / 2)), LEAST),
        joint,
        total,
        float(dof + shot_dof),
    )


def repeat_chi2(problem: Problem, covariance: Covariance, axial: Array) -> tuple[float, int]:
    """Sum of squares of the repeats about their means, whitened by a covariance, and its degrees of
    freedom; axial as in `measure_noise`."""
    deviation, _, dof = scatter_of_repeats(problem)
    W = whitener(problem, covariance, axial, None)
    return float(((W @ deviation.reshape(len(W), -1, 1)) ** 2).sum()), dof
