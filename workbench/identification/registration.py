"""Instrument frame and targets without a first guess, and the mix-up of units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..campaign.problem import Problem
from ..files.faults import Fault, InputError
from ..robot.kinematics import Array, Frames, frames
from ..robot.rotations import body_jacobian, from_vectors

STATED_TARGET = 0.02  # m, how far a stated target may be off before the fit resists
UNKNOWN_TARGET = 1.0  # m, how far an unknown target may be from its frame


def register(problem: Problem) -> tuple[Array, Array, Array]:
    """R: (K, 3, 3), t: (K, 3) and targets: (K, T, 3) of each set-up, from the rigid nominal arm.

    Robust (a few wild points do no harm); where poses cannot tell frame from target, targets stay
    near their stated places.
    """
    campaign = problem.campaign
    out = []
    for k in range(len(campaign.setup_names)):
        here = campaign.poses.setup == k
        out.append(_one_setup(problem, problem.rigid, here)[:3])
    R, t, targets = (np.array(part) for part in zip(*out, strict=True))
    fixed = np.array([target.fixed for target in campaign.targets])
    return R, t, np.where(fixed[:, None], problem.stated_targets, targets)


def check_units(problem: Problem) -> None:
    """Raises InputError when other units of points or joints fit far better than the stated ones."""
    campaign = problem.campaign
    stated, size = _misfit(problem, problem.rigid, 1.0)
    if stated < 0.05 * size or len(campaign.poses.q) < 8:
        return
    rotary = ~problem.arm.prismatic
    best: tuple[float, float, float] | None = None
    for joint_factor in (1.0, np.pi / 180, 180 / np.pi):
        q = np.where(rotary, campaign.poses.q * joint_factor, campaign.poses.q)
        where = problem.rigid if joint_factor == 1.0 else frames(problem.arm, q)
        for factor in (1.0, 1e-3, 1e3):
            if joint_factor == factor == 1.0:
                continue
            misfit, extent = _misfit(problem, where, factor)
            if (
                misfit / extent < 0.05
                and misfit / extent < 0.1 * stated / size
                and (best is None or misfit / extent < best[0])
            ):
                best = misfit / extent, joint_factor, factor
    if best is None:
        return
    said = []
    if best[1] != 1.0:
        said.append(("joints", "degrees, not radians" if best[1] < 1 else "radians, not degrees"))
    if best[2] != 1.0:
        said.append(("points", "millimetres, not metres" if best[2] < 1 else "metres, not millimetres"))
    place = {"joints": "poses", "points": "points"}
    raise InputError(
        [
            Fault(
                f"{campaign.path}: {place[what]}",
                f"the numbers of the {what} fit the robot only if they are {unit}",
                "mend the column's suffix, or say so under `units`",
            )
            for what, unit in said
        ]
    )


def _misfit(problem: Problem, where: Frames, factor: float) -> tuple[float, float]:
    """Median misfit after registration and the arm's extent, both in m; `factor` scales the points."""
    campaign = replace(problem.campaign, points=problem.campaign.points * factor)
    scaled = replace(problem, campaign=campaign)
    misfits, extents = [], []
    for k in range(len(campaign.setup_names)):
        here = campaign.poses.setup == k
        *_, misfit = _one_setup(scaled, where, here)
        misfits.append(misfit)
        extents.append(float(np.linalg.norm(where.p[-1][here].std(axis=0))) + 1e-6)
    return float(np.median(misfits)), float(np.median(extents))


def _one_setup(problem: Problem, where: Frames, here: NDArray[np.bool_]) -> tuple[Array, Array, Array, float]:
    """Best of several starts of one set-up: R, t, targets (T, 3), median misfit [m]."""
    on = problem.on
    R_k = np.stack([where.R[k][here] for k in on], axis=1)
    p_k = np.stack([where.p[k][here] for k in on], axis=1)
    z = problem.campaign.points[here]
    stated = problem.stated_targets
    known = np.asarray(np.isfinite(stated).all(axis=1))
    prior = np.where(known, STATED_TARGET, UNKNOWN_TARGET)
    # a fixed target is held tight
    prior = np.where([target.fixed for target in problem.campaign.targets], 1e-6, prior)
    start = np.where(known[:, None], stated, 0.0)
    best = _refine(R_k, p_k, z, start, prior, *_kabsch(R_k, p_k, z, start))
    if best[3] > 0.02 * (1e-3 + float(np.linalg.norm(p_k.reshape(-1, 3).std(axis=0)))):
        for turn in Rotation.create_group("O"):
            R, t = _turned_start(turn.as_matrix(), R_k, p_k, z, start)
            other = _refine(R_k, p_k, z, start, prior, R, t)
            best = other if other[3] < best[3] else best
    return best


def _kabsch(R_k: Array, p_k: Array, z: Array, targets: Array) -> tuple[Array, Array]:
    points = p_k + np.einsum("ntij,tj->nti", R_k, targets)
    seen = np.asarray(np.isfinite(z).all(axis=2))
    a, b = points[seen], z[seen]
    ca, cb = np.median(a, axis=0), np.median(b, axis=0)
    rotation, _ = Rotation.align_vectors(b - cb, a - ca) if len(a) > 1 else (Rotation.identity(), 0)
    R = rotation.as_matrix()
    return R, cb - R @ ca


def _turned_start(turn: Array, R_k: Array, p_k: Array, z: Array, targets: Array) -> tuple[Array, Array]:
    points = p_k + np.einsum("ntij,tj->nti", R_k, targets)
    return turn, np.nanmedian(z.reshape(-1, 3), axis=0) - turn @ np.median(points.reshape(-1, 3), axis=0)


def _refine(
    R_k: Array, p_k: Array, z: Array, start: Array, prior: Array, R: Array, t: Array
) -> tuple[Array, Array, Array, float]:
    """Gauss–Newton on frame and targets with weights 1/misfit (robust)."""
    n_targets = z.shape[1]
    targets = start.copy()
    seen = np.asarray(np.isfinite(z).all(axis=2))
    misfit = np.inf
    for _ in range(40):
        local = p_k + np.einsum("ntij,tj->nti", R_k, targets)
        points = local @ R.T + t
        residual = np.where(seen[..., None], z - points, 0.0)
        length = np.linalg.norm(residual, axis=2)
        misfit, last = float(np.median(length[seen])), misfit
        weight = seen / np.sqrt(length**2 + (1.5 * misfit + 1e-9) ** 2)
        J = np.zeros((*z.shape, 6 + 3 * n_targets))
        J[..., :6] = body_jacobian(points - t)
        for i in range(n_targets):
            J[:, i, :, 6 + 3 * i : 9 + 3 * i] = R @ R_k[:, i]
        scale = misfit + 1e-6
        flat = J.reshape(-1, J.shape[-1])
        pull = flat.T * np.repeat(weight / scale, 3)
        A, g = pull @ flat, pull @ residual.ravel()
        hold = np.repeat(prior, 3) ** -2.0
        A[np.diag_indices(6)] += 1e-9
        A[6:, 6:] += np.diag(hold)
        g[6:] -= hold * (targets - start).ravel()
        step = np.linalg.solve(A, g)
        R = from_vectors(step[3:6]) @ R
        t = t + step[:3]
        targets = targets + step[6:].reshape(-1, 3)
        if float(np.abs(step).max()) < 1e-9 or (_ > 15 and misfit > 0.999 * last):
            break
    return R, t, targets, misfit
